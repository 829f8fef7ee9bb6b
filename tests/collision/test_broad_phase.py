"""Worlds that share parts of their broadphase answer as those that share nothing, after any changes and back again."""

from dataclasses import replace

import numpy as np

from planner.collision.broad_phase import BroadPhase
from planner.collision.coal import CoalChecker
from planner.collision.world import World
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle, Sphere
from tests.worlds import load

ROBOT = load("panda")


def crowd(count: int, rng: np.random.Generator) -> tuple[Obstacle, ...]:
    """Obstacles around the arm, of which a few reach into where it goes."""
    at = rng.uniform([-1.5, -1.5, -0.2], [1.5, 1.5, 1.6], (count, 3))
    at[:, :2] *= np.maximum(1.0, 0.7 / np.linalg.norm(at[:, :2], axis=1))[:, None]
    return tuple(Obstacle(f"o{k}", Box((0.04, 0.04, 0.04)), pose(place)) for k, place in enumerate(at))


def world_of(obstacles: tuple[Obstacle, ...]) -> World:
    return World.from_scene(ROBOT, Scene("x", obstacles), ROBOT.disabled_pairs or frozenset())


def changed(obstacles: tuple[Obstacle, ...], k: int, rng: np.random.Generator) -> tuple[Obstacle, ...]:
    """With one more, one less, one elsewhere, or one that was taken out and put in again."""
    row = int(rng.integers(len(obstacles)))
    one, others = obstacles[row], (*obstacles[:row], *obstacles[row + 1 :])
    there = pose(rng.uniform([0.3, -0.5, 0.2], [0.7, 0.5, 1.0]).tolist())
    match k % 4:
        case 0:
            return (*obstacles, Obstacle(f"new{k}", Sphere(0.08), there))
        case 1:
            return others
        case 2:
            return (*others, replace(one, placement=there))
    return (*obstacles[:row], replace(one, placement=there), *obstacles[row + 1 :])


def parts(checker: CoalChecker) -> list[int]:
    broadphase: BroadPhase = checker._broad.phase
    return [id(view.part) for view in broadphase._views]


def test_after_any_changes_and_back_again_it_answers_as_one_that_shares_nothing() -> None:
    rng = np.random.default_rng(0)
    obstacles = crowd(320, rng)
    q = rng.uniform(0.6 * ROBOT.lower, 0.6 * ROBOT.upper, (60, ROBOT.dof))
    shared = [CoalChecker(world_of(obstacles))]
    fresh = [shared[0]]
    for k in range(16):
        obstacles, before = changed(obstacles, k, rng), parts(shared[-1])  # a checker without questions has none
        shared.append(CoalChecker(world_of(obstacles), shared[-1]))
        fresh.append(CoalChecker(world_of(obstacles)))
        assert set(parts(shared[-1])) & set(before), "the parts that are as they were"
        assert len(parts(shared[-1])) <= 8
    verdicts = set()
    for k in (16, 3, 9, 0, 12, 1, 15, 2):  # as undo goes back to any of them
        found = [shared[k].first_contact(one[None]) for one in q]
        assert found == [fresh[k].first_contact(one[None]) for one in q]
        assert shared[k].first_contact(q) == fresh[k].first_contact(q)
        motion = np.full(shared[k].world.pair_reach.shape[0], 0.01)
        assert shared[k].first_contact_along(q[:20], motion) == fresh[k].first_contact_along(q[:20], motion)
        verdicts.add(str(found))
    assert len(verdicts) > 4


def test_every_thread_uses_the_requested_margins() -> None:
    """Few configurations are asked by one thread, many by all; each has margins of its own to keep up with."""
    rng = np.random.default_rng(4)
    world = world_of(crowd(12, rng))
    many = rng.uniform(0.6 * ROBOT.lower, 0.6 * ROBOT.upper, (400, ROBOT.dof))
    margins = [np.full(world.pair_reach.shape[0], margin) for margin in (0.0, 0.05)]
    want = [CoalChecker(world)._broad.phase.touching(world, many, margin) for margin in margins]
    assert want[0].sum() < want[1].sum()
    phase = CoalChecker(world)._broad.phase
    for k, count in ((0, 400), (1, 30), (0, 400), (1, 400), (0, 30), (1, 400), (1, 30)):
        np.testing.assert_array_equal(phase.touching(world, many[-count:], margins[k]), want[k][-count:])
