"""Motions along paths: limits exactly kept, curves proven, ends at rest, corners rounded only where there is room."""

import itertools
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from planner.base.polynomials import evaluate
from planner.collision import make_checker, second_checker
from planner.collision.recheck import sample_contacts
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.planning.result import Plan
from planner.problem.options import TimeLaw
from planner.problem.request import LimitsRequest
from planner.robot.poses import pose
from planner.robot.shapes import Box, Sphere
from planner.trajectory.curve import corner_parabolas, drop_standstills
from planner.trajectory.limits import KINDS, USED, MotionLimits
from planner.trajectory.timing import DEVIATION, time_path
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load, scene_of

ARM = load("planar_2r")
FREE = make_checker(ARM, scene_of((Box((0.1, 0.1, 0.1)), pose([5.0, 0.0, 0.0]))))


def zigzag(seed: int, corners: int = 5, dof: int = 7, size: float = 0.4) -> np.ndarray:
    return np.cumsum(np.random.default_rng(seed).normal(size=(corners + 2, dof)) * size, axis=0)


def require_within(trajectory: Trajectory, limits: MotionLimits) -> None:
    """By the exact extrema, by dense samples of the same, and by the points as another program interpolates them."""
    t = np.linspace(0.0, trajectory.duration, 20_001)
    for order, kind in enumerate(KINDS, start=1):
        assert (trajectory.largest(order) <= getattr(limits, kind)).all(), kind
        assert (np.abs(trajectory.at(t, order)) <= getattr(limits, kind) * (1 + 1e-9)).all(), kind
    for order in (1, 2):  # neither jumps, so that the jerk is all that the pieces say
        before, after = trajectory.ends(order)
        assert np.abs(before[:-1] - after[1:]).max() <= 1e-9


@pytest.mark.parametrize("law", get_args(TimeLaw))
@pytest.mark.parametrize("seed", [0, 1])
def test_limits_hold_exactly_and_it_ends_where_the_path_does(law: TimeLaw, seed: int) -> None:
    path = 0.3 * zigzag(seed, dof=2)
    limits = MotionLimits.from_robot(ARM, LimitsRequest(velocity_scale=0.7))
    found = time_path(path, FREE, limits, time_law=law)
    require_within(found, limits)
    np.testing.assert_allclose(found.at(np.array([0.0, found.duration])), path[[0, -1]], rtol=0, atol=1e-15)
    assert not found.knots(1)[[0, -1]].any()
    assert found.proven
    assert (np.diff(np.round(found.times * 1e9)) > 0).all()
    np.testing.assert_array_equal(found.times, np.round(found.times * 1e9) / 1e9)


H = 0.3 * np.eye(7)
GIVEN = {
    "a loop": np.array([0 * H[0], H[0], H[0] + H[3], H[3], 0 * H[0]]),
    "up and down one joint": H[0] * np.array([[0.0], [1.0], [0.2], [0.7], [-0.4]]),
    "there and back over the same waypoints": H[[0, 1, 2, 1, 0]],
    "waypoints on a line": np.linspace(0.0, 1.0, 6)[:, None] ** 2 * H.sum(axis=0),
    "a loop smaller than the deviation": 0.02 * np.array([0 * H[0], H[0], H[0] + H[1], H[1], 0 * H[0], 90 * H[2]]),
    **{f"zigzag {seed}": zigzag(seed, size=0.12) for seed in range(3)},
    "many": zigzag(4, corners=40, size=0.05),
}


@pytest.mark.parametrize(("deviation", "jerk"), [(1e-3, 60.0), (None, None), (0.2, None)])
@pytest.mark.parametrize("name", GIVEN)
def test_a_given_path_is_passed_corner_by_corner(name: str, deviation: float | None, jerk: float | None) -> None:
    """In the order of the waypoints, by samples that know nothing of the curve; a low jerk takes more of the room."""
    robot = load("panda")
    path, limits = robot.home + GIVEN[name], MotionLimits.from_robot(robot, LimitsRequest(jerk=jerk))
    checker = make_checker(robot, scene_of((Sphere(0.01), pose([3.0, 0.0, 0.0]))))
    asked, allowed, row = {} if deviation is None else {"deviation": deviation}, deviation or DEVIATION, 0
    motion = time_path(path, checker, limits, **asked)
    q = motion.at(np.linspace(0.0, motion.duration, 100_001))
    for waypoint in path:
        near = np.flatnonzero(np.abs(q[row:] - waypoint).max(axis=1) <= 1.01 * allowed)
        assert len(near), "it is passed farther away"
        row += int(near[0])
    assert motion.proven
    require_within(motion, limits)
    if jerk is None and len(path) < 40 and deviation == 0.2:
        assert motion.duration < time_path(path, checker, limits, time_law="stop-at-corners").duration


def test_stopping_stays_on_the_path_and_takes_as_long_as_trapezoids_do() -> None:
    path = 0.3 * zigzag(2, dof=2)
    limits = MotionLimits.from_robot(ARM)
    found = time_path(path, FREE, limits, time_law="stop-at-corners")
    t, off = np.linspace(0.0, found.duration, 3001), np.full(3001, np.inf)
    for a, b in itertools.pairwise(path):
        share = np.clip((found.at(t) - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        off = np.minimum(off, np.abs(a + share[:, None] * (b - a) - found.at(t)).max(axis=1))
    assert off.max() < 1e-9
    window, limits = (2 * limits.acceleration / limits.jerk).max(), limits.scale_all(USED)
    want = 0.0
    for step in np.abs(np.diff(path, axis=0)):
        v, a = (limits.velocity / step).min(), (limits.acceleration / step).min()
        want += window + (1 / v + v / a if v * v <= a else 2 / np.sqrt(a))
    assert found.duration == pytest.approx(want, abs=1e-6)


def test_corners_are_rounded_when_there_is_room_and_that_is_quicker() -> None:
    path = np.array([[-1.0, 0.5], [0.0, 1.0], [1.0, 0.5], [1.2, -0.5]])
    stop, blend = (time_path(path, FREE, time_law=law, deviation=np.inf) for law in ("stop-at-corners", "blended"))
    assert blend.proof["corners_blended"] == blend.proof["corners"] == 2
    assert blend.duration < 0.8 * stop.duration


def test_a_corner_next_to_an_obstacle_is_rounded_less_and_the_result_is_free() -> None:
    """A ball is held where the flange comes by in the middle of the widest rounding."""
    robot = load("iiwa14")
    path = np.array([[-0.6, 1.3, -0.2, -1.5, 0.6, 0.8, -0.1], robot.home, [0.1, 0.8, 0.4, -1.8, 0.8, 1.2, -0.2]])
    middle = evaluate(corner_parabolas(path, np.ones(1)), np.array([0.5]))
    empty = make_checker(robot, scene_of((Sphere(0.01), pose([3.0, 0.0, 0.0]))))
    checker = make_checker(robot, scene_of((Sphere(0.01), pose(tool_positions(robot, middle)[0]))))
    wide, found = (time_path(path, each, deviation=np.inf) for each in (empty, checker))
    assert found.proven
    assert wide.proven
    assert found.duration > wide.duration + 1e-3
    assert sample_contacts(second_checker(checker), found.coefficients, 1e-3) is None
    assert sample_contacts(second_checker(checker), wide.coefficients, 1e-3) is not None


def test_a_floor_is_proven_between_the_samples_or_not_at_all() -> None:
    path = np.array([[-0.8, 0.6], [0.0, 0.5], [0.8, 0.6]])
    lowest = float(manipulability(ARM, path).min())
    kept = time_path(path, FREE, floor=0.999 * lowest, time_law="stop-at-corners")
    broken = time_path(path, FREE, floor=1.001 * lowest, time_law="stop-at-corners")
    assert kept.proven
    assert kept.proof["floor"]["pieces_above"] == kept.proof["pieces"]
    assert not broken.proven
    assert broken.proof["floor"]["pieces_above"] < broken.proof["pieces"] == broken.proof["pieces_free"]


def test_one_configuration_and_a_path_that_stands_still() -> None:
    for path in (np.array([[0.1, 0.2]]), np.array([[0.1, 0.2], [0.1, 0.2]])):
        found = time_path(path, FREE)
        assert found.duration > 0
        np.testing.assert_array_equal(found.at(np.array([found.duration])), path[:1])
    path = np.array([[0.0, 0.0], [0.0, 0.0], [0.5, 0.0], [0.5, 1e-9]])
    np.testing.assert_array_equal(drop_standstills(path), path[[0, 3]])


def test_a_plan_is_rounded_and_the_same_every_time(solved: Plan) -> None:
    found = time_path(solved.path, solved.checker)
    again = time_path(solved.path, type(solved.checker)(replace(solved.checker.world)))
    np.testing.assert_array_equal(found.coefficients, again.coefficients)
    assert found.proof["corners_blended"] > 0
    assert found.proven
    assert sample_contacts(second_checker(solved.checker), found.coefficients, 1e-3) is None
    require_within(found, MotionLimits.from_robot(solved.robot))
