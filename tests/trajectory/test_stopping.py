"""Braking at any moment: from the state that there is, along the same curve, within limits, to rest, proven."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from planner.collision import make_checker
from planner.kinematics.forward import tool_positions
from planner.planning.result import Plan
from planner.problem.options import TimeLaw
from planner.problem.request import LimitsRequest
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Sphere
from planner.trajectory.limits import MotionLimits
from planner.trajectory.stopping import Stop, stop_at
from planner.trajectory.timing import time_path
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load, scene_of


def braked(motion: Trajectory, t: float) -> Stop:
    """The stop from ``t`` s on, which keeps all limits, starts as the motion goes and stays on its curve."""
    assert motion.limits is not None
    stop = stop_at(motion, t)
    made = stop.trajectory
    assert stop.excess == 0.0
    assert (made.largest(1) <= motion.limits.velocity).all()
    assert (made.largest(2) <= motion.limits.acceleration).all()
    np.testing.assert_allclose(made.at(0.0), motion.at(t), atol=1e-12)
    np.testing.assert_allclose(made.at(0.0, 1), motion.at(t, 1), atol=1e-8)
    assert not made.knots(1)[-1].any()
    np.testing.assert_allclose(made.at(made.duration), motion.at(stop.rest), atol=1e-12)
    assert made.duration <= motion.duration - t + 0.01
    assert off_curve(motion, t, stop) < 3e-7
    return stop


def off_curve(motion: Trajectory, t: float, stop: Stop) -> float:
    """How far states of the stop are from the nearest moment of the motion, looked for anew around the nearest."""
    times, far = np.linspace(t, stop.rest, 2001), []
    curve, apart = motion.at(times), times[1] - times[0]
    for q in stop.trajectory.at(np.linspace(0.0, stop.trajectory.duration, 25)):
        near = times[np.abs(curve - q).max(axis=1).argmin()] + apart * np.linspace(-1.0, 1.0, 2001)
        far.append(np.abs(motion.at(near) - q).max(axis=1).min())
    return max(far)


@pytest.mark.parametrize("law", get_args(TimeLaw))
@pytest.mark.parametrize("slow", [LimitsRequest(), LimitsRequest(velocity_scale=0.3, acceleration=20.0, jerk=4000.0)])
def test_at_random_moments_it_brakes_along_the_curve_within_limits(
    law: TimeLaw, slow: LimitsRequest, solved: Plan
) -> None:
    motion = time_path(solved.path, solved.checker, MotionLimits.from_robot(solved.robot, slow), time_law=law)
    moments = np.random.default_rng(7).uniform(0.0, motion.duration, 20)
    for t in [0.0, *moments.tolist(), motion.duration - 1e-4, motion.duration]:
        braked(motion, t)


@pytest.mark.parametrize(("size", "jerk"), [(3e-4, 2e5), (0.02, 4000.0), (0.3, 100.0)])
def test_no_moment_is_found_at_which_a_limit_is_exceeded(size: float, jerk: float) -> None:
    """By a search that climbs from the moment with the largest share of a limit; pieces are as short as the jerk."""
    arm = load("panda")
    path = np.cumsum(np.random.default_rng(26).normal(size=(8, 7)) * size, axis=0) * 0.5 + arm.home
    limits = replace(MotionLimits.from_robot(arm), jerk=np.full(7, jerk))
    motion = time_path(path, make_checker(arm, scene_of((Sphere(0.01), pose([3.0, 0, 0])))), limits)
    rng = np.random.default_rng(1)

    def share(t: float) -> float:
        made = stop_at(motion, t).trajectory
        return max(made.worst(1, limits.velocity)[0], made.worst(2, limits.acceleration)[0])

    moments = [*rng.uniform(0.0, motion.duration, 30), *(motion.times[1:-1] - 1e-6)[:: len(motion.times) // 10]]
    shares = [share(t) for t in moments]
    best, t = max(zip(shares, moments, strict=True))
    step = motion.duration / 30
    for _ in range(25):
        tried = float(np.clip(t + step * rng.normal(), 0.0, motion.duration))
        step *= 0.8
        if (found := share(tried)) > best:
            best, t = found, tried
    assert 0.99 < best <= 1.0


def test_a_stop_is_proven_with_a_checker_and_not_without_one(solved: Plan) -> None:
    motion = time_path(solved.path, solved.checker)
    bare, stop = (stop_at(motion, 0.4 * motion.duration, checker) for checker in (None, solved.checker))
    assert not bare.proven
    assert "not proven: give stop_at the checker" in bare.text()
    assert stop.proven
    assert stop.trajectory.proof["pieces_free"] == len(stop.trajectory.seconds)
    assert "proven free" in stop.text()
    assert stop.trajectory.duration > 0.01
    np.testing.assert_array_equal(stop.trajectory.coefficients, bare.trajectory.coefficients)


def test_a_stop_through_something_is_not_proven(solved: Plan) -> None:
    """A ball stands where the flange comes by while it brakes, and elsewhere while it does not."""
    motion = time_path(solved.path, solved.checker)
    t = 0.4 * motion.duration
    stop = stop_at(motion, t)
    there = tool_positions(solved.robot, stop.trajectory.at(0.5 * stop.trajectory.duration))[0]
    away = tool_positions(solved.robot, motion.at(motion.duration))[0]
    hit, clear = (
        stop_at(motion, t, make_checker(solved.robot, scene_of((Sphere(0.01), pose(place))))) for place in (there, away)
    )
    assert not hit.proven
    assert clear.proven


def test_among_what_moves_the_stop_is_proven_at_its_own_times_until_all_rests() -> None:
    """A cart comes by where the arm stands after the stop: before it is there all is clear, later it is not."""
    arm = load("planar_2r")
    motion = time_path(np.array([[-1.0, 0.3], [1.0, 0.3]]), make_checker(arm, Scene("none")))
    t = 0.5 * motion.duration
    place = tool_positions(arm, stop_at(motion, t).trajectory.at(9.0))[0]
    for comes, proven in (([*place[:2], 0.0], False), ([*(-place[:2]), 0.0], True)):
        way = KnownMotion([0.0, 50.0, 51.0], [pose([3.0, 3.0, 0.0]), pose([3.0, 3.0, 0.0]), pose(comes)])
        scene = Scene("cart", (), moving=(MovingObstacle("cart", Box((0.1, 0.1, 0.1)), way),))
        assert stop_at(motion, t, make_checker(arm, scene)).proven == proven


def test_what_a_trajectory_breaks_itself_is_told_as_excess(solved: Plan) -> None:
    motion = time_path(solved.path, solved.checker)
    assert motion.limits is not None
    slower = replace(motion, limits=replace(motion.limits, velocity=0.5 * motion.limits.velocity))
    stop = stop_at(slower, float(motion.times[motion.largest(1).max(axis=1).argmax()]), solved.checker)
    assert stop.excess > 0.1
    assert not stop.proven
    assert "over a limit" in stop.text()
