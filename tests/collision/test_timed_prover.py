"""Proofs in time against dense sampling in time by collision libraries that know nothing of them."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from planner.base.polynomials import evaluate
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.coal import CoalInTime
from planner.collision.timed_prover import TimedProver, moving_world
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Mesh, Obstacle
from tests.random_shapes import KINDS, box_mesh, random_shape
from tests.worlds import joint_xml, link_xml, load

PIECES = 8


def moving(rng: np.random.Generator, kind: str) -> MovingObstacle:
    places = [[*rng.uniform(-1, 1, 2), rng.uniform(-0.05, 0.05)] for _ in range(3)]
    poses = [pose(place, rng.uniform(-2, 2, 3).tolist()) for place in places]
    return MovingObstacle("mover", random_shape(rng, kind), KnownMotion([0.0, 1.0, 2.5], poses))


def touches(checker: CollisionChecker, obstacle: MovingObstacle, q: np.ndarray, t: np.ndarray) -> bool:
    """Whether the robot touches the obstacle in any of the configurations at their times, by the checker's library."""
    known = checker
    for row, when in zip(q, t, strict=True):
        known = type(checker)(moving_world(checker.world, (obstacle.standing(when),)), known)
        if known.first_contact(row[None]) is not None:
            return True
    return False


@pytest.mark.parametrize("kind", KINDS)
def test_a_motion_proven_in_time_touches_at_no_sampled_moment(kind: str) -> None:
    rng, checker = np.random.default_rng(len(kind)), make_checker(load("planar_2r"), Scene("none"), "fcl")
    proven = touched = 0
    for _ in range(6):
        obstacle = moving(rng, kind)
        prover = TimedProver(checker, [obstacle])
        judge = CoalInTime(prover.world, prover.motions)
        coefficients = rng.uniform(-1, 1, (PIECES, 4, 2))
        spans = np.column_stack(
            [rng.uniform(0, 2.5, PIECES), rng.uniform(0.1, 1, PIECES), rng.choice([0.0, 0.1], PIECES)]
        )
        free = prover.free(coefficients, spans)
        for k in range(PIECES):
            s, (begin, takes, slack) = np.linspace(0, 1, 400), spans[k]
            q, t = evaluate(np.repeat(coefficients[k][None], 400, axis=0), s), begin + takes * s
            shift = slack * rng.uniform(-1, 1)
            if free[k]:
                assert judge.first_touch(q, t + shift) is None
                assert not touches(checker, obstacle, q[::40], t[::40] + shift)
                proven += 1
            elif slack == 0 and judge.first_touch(q, t) is not None:
                touched += 1
            else:
                assert slack > 0  # what is free of a piece begun on time is proven
    assert proven > 5
    assert touched > 1


def dithering(rng: np.random.Generator) -> tuple[MovingObstacle, np.ndarray, np.ndarray]:
    """A long bar that turns to and fro, far and quickly, and hardly goes anywhere: how far it gets bounds it.

    With its middle in its frame, which need not be in it, and half its sides.
    """
    count = int(rng.integers(2, 14))
    turns = rng.choice([0.0, 0.4, 1.5, 3.1], count) * rng.choice([-1, 1], count)
    turns = np.cumsum(turns) if rng.random() < 0.3 else turns
    places = rng.normal(size=2) + rng.choice([0.0, 0.02, 0.3]) * rng.normal(size=(count, 2))
    poses = [pose([*place, 0.0], [0, 0, turn]) for place, turn in zip(places, turns.tolist(), strict=True)]
    times = np.append(0.0, np.cumsum(rng.choice([1e-3, 0.02, 0.1, 0.5], count - 1)))
    size = rng.uniform([0.3, 0.02, 0.02], [1.5, 0.1, 0.1])
    middle = rng.choice([0.0, 0.5, 0.9]) * np.array([size[0], 0.0, 0.0])
    bar = box_mesh(tuple(size.tolist()))
    shape = Mesh(bar.vertices + middle, bar.triangles) if middle.any() else Box(tuple(size.tolist()))
    return MovingObstacle("bar", shape, KnownMotion(times, poses)), middle, 0.5 * size


def test_no_bar_that_turns_to_and_fro_comes_nearer_than_was_proven(urdf_file: Callable[..., str]) -> None:
    """The margin is set a tenth of a millimetre above, and as much below, the least that an optimiser finds."""
    arm = link_xml("a") + link_xml("b", '<sphere radius="0.02"/>', '<origin xyz="0.3 0 0"/>') + joint_xml("j", "a", "b")
    robot, rng = Robot.load(urdf_file(arm)), np.random.default_rng(3)
    proven = 0
    for _ in range(50):
        (bar, centre, half), q = dithering(rng), rng.uniform(-1, 1)
        ball = np.array([0.3 * np.cos(q), 0.3 * np.sin(q), 0.0])
        begin, slack = rng.uniform(-0.1, 0.1), rng.choice([0.0, 0.05, 0.2])
        takes = float(bar.motion.times[-1]) * rng.choice([0.3, 1.0, 1.2]) + 1e-3

        def gap(t: np.ndarray, bar=bar, ball=ball, centre=centre, half=half) -> np.ndarray:
            place = bar.motion.at(np.maximum(t, 0.0))
            local = np.einsum("nji,nj->ni", place[:, :3, :3], ball - place[:, :3, 3]) - centre
            return np.linalg.norm(np.maximum(np.abs(local) - half, 0.0), axis=1) - 0.02

        low, high = begin - slack, begin + takes + slack
        t = np.unique(np.clip(np.concatenate([np.linspace(low, high, 4001), bar.motion.times]), low, high))
        k = int(gap(t).argmin())
        around = t[max(0, k - 1)], t[min(len(t) - 1, k + 1)]
        found: Any = minimize_scalar(lambda x, gap=gap: float(gap(np.array([x]))[0]), bounds=around)
        least = min(float(gap(t).min()), float(found.fun))
        if least < 1e-3:
            continue
        still, span = np.array([[[q], [0.0]]]), np.array([[begin, takes, slack]])
        for margin, must_not in ((least + 1e-4, True), (least - 1e-4, False)):
            free = TimedProver(make_checker(robot, Scene("none"), margin=margin), [bar]).free(still, span)[0]
            assert not (free and must_not)
            proven += bool(free)
    assert proven > 7, "what keeps clear is proven"


def test_coal_in_time_agrees_with_fcl_at_single_moments() -> None:
    rng, checker = np.random.default_rng(4), make_checker(load("planar_2r"), Scene("none"), "fcl")
    obstacle, verdicts = replace(moving(rng, "box"), shape=Box((0.5, 0.4, 0.2))), []
    prover = TimedProver(checker, [obstacle])
    judge = CoalInTime(prover.world, prover.motions)
    for q, t in zip(rng.uniform(-3, 3, (150, 2)), rng.uniform(0, 3, 150), strict=True):
        found = judge.first_touch(q[None], np.array([t]))
        assert (found is not None) == touches(checker, obstacle, q[None], np.array([t]))
        verdicts.append(found is not None)
        if found is not None:
            assert found[1].second == "mover"
    assert 5 < sum(verdicts) < 145


def test_the_margin_is_kept_and_permissions_hold() -> None:
    cart = MovingObstacle("cart", Box((0.1, 0.1, 0.1)), KnownMotion([0, 1], [pose([1.3, 0, 0]), pose([1.3, 1, 0])]))
    still, span = np.zeros((1, 2, 2)), np.array([[0.0, 1.0, 0.0]])
    gap = 1.25 - np.abs(TimedProver(make_checker(load("planar_2r"), Scene("none")), [cart]).gaps(np.zeros(2)).min())
    for margin, free in ((0.0, True), (0.5 * (1.25 - gap), True), (1.25 - gap + 0.01, False)):
        checker = make_checker(load("planar_2r"), Scene("none"), margin=margin)
        assert TimedProver(checker, [cart]).free(still, span)[0] == free
    links = {body.link for body in load("planar_2r").bodies}
    allowed = Scene("allowed", allowed=frozenset(frozenset((link, "cart")) for link in links))
    inside = MovingObstacle("cart", cart.shape, KnownMotion([0], [pose([0.5, 0, 0])]))
    prover = TimedProver(make_checker(load("planar_2r"), allowed), [inside])
    assert prover.free(still, span)[0]


def test_an_unknown_motion_is_kept_clear_of_as_long_as_it_cannot_have_come() -> None:
    checker = make_checker(load("planar_2r"), Scene("none"))
    dog = Obstacle("dog", Box((0.2, 0.2, 0.2)), pose([2.0, 0, 0]), speed_limit=0.5)
    prover = TimedProver(checker, limited=[dog])
    gap = prover.gaps(np.zeros(2)).min()
    still = np.zeros((2, 2, 2))
    spans = np.array([[0.0, 0.99 * gap / 0.5, 0.0], [0.0, 1.01 * gap / 0.5, 0.0]])
    np.testing.assert_array_equal(prover.free(still, spans), [True, False])
    late = np.array([[0.97 * gap / 0.5, 0.01, 0.01], [0.99 * gap / 0.5, 0.01, 0.01]])
    np.testing.assert_array_equal(prover.free(still, late), [True, False])
