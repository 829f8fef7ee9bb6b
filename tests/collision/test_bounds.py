"""Clearance bounds never exceed the distance that FCL or coal finds."""

from dataclasses import replace

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.bounds import ClearanceBound
from planner.collision.timed_prover import moving_world
from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.moving import KnownMotion
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle, Sphere
from tests.coal_judge import CoalWorld
from tests.random_shapes import KINDS, PRIMITIVES, random_pose, random_shape
from tests.worlds import body, checker_of, load, random_q, scene_of

COAL = 1e-6  # m: coal's own tolerance
REGIMES = ("normal", "thin", "large")


def random_scene(seed: int, count: int = 6) -> Scene:
    rng = np.random.default_rng(seed)
    items = [
        (random_shape(rng, KINDS[k % len(KINDS)], REGIMES[int(rng.integers(3))]), random_pose(rng, 1.2))
        for k in range(count)
    ]
    return scene_of(*items)


def both_bounds(world: World, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, pairs) coarse and close."""
    bound = ClearanceBound(world)
    rotation, position = joint_placements(Chain.from_arm(world.robot), q)
    coarse = bound.coarse(rotation, position)
    rows, pairs = (grid.ravel() for grid in np.indices(coarse.shape))
    return coarse, bound.close(rotation, position, rows, pairs).reshape(coarse.shape)


@pytest.mark.parametrize("name", ["iiwa14", "panda", "ur5", "kinova", "planar_2r"])
def test_never_above_coals_distance(name):
    scene = random_scene(len(name), 10)
    world = make_checker(load(name), scene).world
    judge, q = CoalWorld(world), random_q(load(name), 6, seed=8)
    coarse, fine = both_bounds(world, q)
    for k, row in enumerate(q):
        truth = judge.distances(row)
        apart = truth > 0
        assert (coarse[k][apart] <= truth[apart] + COAL).all()
        assert (fine[k][apart] <= truth[apart] + COAL).all()
        assert (coarse[k][~apart] <= COAL).all()
        assert (fine[k][~apart] <= COAL).all()


def world_of(shape_a, place_a, shape_b, place_b) -> World:
    robot = replace(load("planar_2r"), bodies=(body(shape_a, place_a),))
    return World.from_scene(robot, scene_of((shape_b, place_b)), frozenset())


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule"])
def test_a_ball_against_a_primitive_is_exact(kind):
    """The formula behind the bound, not merely something small: for a sphere it is the distance itself."""
    rng = np.random.default_rng(6)
    assert kind in PRIMITIVES
    for _ in range(50):
        world = world_of(Sphere(0.1), random_pose(rng), random_shape(rng, kind), random_pose(rng))
        truth = CoalWorld(world).distances(np.zeros(2))[0]
        coarse, _ = both_bounds(world, np.zeros((1, 2)))
        if truth > 0:
            assert coarse[0, 0] == pytest.approx(truth, abs=1e-6)


@pytest.mark.parametrize("name", ["iiwa14", "panda"])
def test_bounds_are_of_use(name):
    """For most pairs that are 20 cm apart the bound is at least 5 cm."""
    world = checker_of(name, "paper").world
    q = random_q(load(name), 8, seed=2)
    coarse, _ = both_bounds(world, q)
    truth = np.array([CoalWorld(world).distances(row) for row in q])
    far = truth > 0.2
    assert (coarse[far] > 0.05).mean() > 0.95


def test_motions_of_another_world_are_taken_over_unless_they_are_given() -> None:
    """An obstacle that comes to where the arm is: refused in every world that takes it over."""
    far, near = pose([3.0, 0.0, 0.0]), pose([0.6, 0.0, 0.0])
    coming, staying = KnownMotion([0.0, 4.0], [far, near]), KnownMotion([0.0, 4.0], [far, far])
    world = moving_world(checker_of("planar_2r").world, (Obstacle("ball", Sphere(0.1), far),))
    first = ClearanceBound(world, motions={"ball": coming})
    taken = ClearanceBound(world, first)
    said = ClearanceBound(world, first, {"ball": staying})
    standing = ClearanceBound(world)
    moves = np.zeros(len(world.pair_reach), dtype=bool)
    curves, spans = np.zeros((1, 2, 2)), np.array([[3.9, 0.1, 0.0]])

    def verdict(bound: ClearanceBound) -> int:
        bounds = bound.native.bounds(world.pair_reach, world.reach.bodies, moves)
        return int(bound.native.prove(bounds, curves, 1e-3, spans)[0][0])

    assert [verdict(bound) for bound in (first, taken, said, standing)] == [2, 2, 0, 0]


@pytest.mark.parametrize("kind", KINDS)
def test_a_look_finds_pairs_within_the_margin_and_no_others(kind: str) -> None:
    """Balls around bodies and obstacles clear far pairs; they must not clear a pair at the margin."""
    rng, robot = np.random.default_rng(0), load("iiwa14")
    for _ in range(8):
        shape = random_shape(rng, kind, str(rng.choice(["normal", "thin", "large"])))
        obstacles = tuple(Obstacle(f"{k}", shape, random_pose(rng, 3.0)) for k in range(2))
        world = World.from_scene(robot, Scene("x", obstacles), robot.disabled_pairs or frozenset())
        world = replace(world, self_pairs=world.self_pairs[:0])
        q = random_q(robot, 1, int(rng.integers(1000)))
        rotation, position = joint_placements(Chain.from_arm(robot), q)
        pairs = np.arange(world.checked.size)
        gap = ClearanceBound(world).close(rotation, position, np.zeros_like(pairs), pairs).min()
        if gap > 1e-3:
            assert ClearanceBound(replace(world, margin=0.999999 * gap)).is_clear(q)
            assert not ClearanceBound(replace(world, margin=1.000001 * gap)).is_clear(q)


def test_each_of_many_states_is_told_as_if_it_were_alone() -> None:
    bound, q = checker_of("panda", "shelf").bound, random_q(load("panda"), 200, 1)
    alone = [bound.is_clear(one[None]) for one in q]
    assert 20 < sum(alone) < 180
    for rows in (slice(None), np.flatnonzero(alone), ~np.array(alone), slice(0)):
        assert bound.is_each_clear(q[rows]).tolist() == np.array(alone)[rows].tolist()
