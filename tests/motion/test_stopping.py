"""Braking at any moment: from the state that there is, along the same curve, within limits, to rest."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from planner.base.errors import PlannerError
from planner.base.request import LimitsRequest, TimeLaw
from planner.motion.limits import MotionLimits
from planner.motion.timing import time_path
from planner.motion.trajectory import Trajectory
from planner.plan_record import Plan


def braked(motion: Trajectory, t: float) -> Trajectory:
    """The stop from ``t`` s on, which keeps all limits, starts as the motion goes and stays on its curve."""
    assert motion.limits is not None
    stop = motion.stop_at(t)
    made = stop.trajectory
    assert stop.excess == 0.0
    assert (made.largest(1) <= motion.limits.velocity).all()
    assert (made.largest(2) <= motion.limits.acceleration).all()
    np.testing.assert_allclose(made.at(0.0), motion.at(t), atol=1e-12)
    np.testing.assert_allclose(made.at(0.0, 1), motion.at(t, 1), atol=1e-8)
    assert not made.knots(1)[-1].any()
    np.testing.assert_allclose(made.at(made.duration), motion.at(stop.rest), atol=1e-12)
    assert made.duration <= motion.duration - t + 0.01
    curve = motion.at(np.linspace(t, stop.rest, 4001))
    for q in made.at(np.linspace(0.0, made.duration, 25)):
        assert np.abs(curve - q).max(axis=1).min() < 1e-4
    return made


@pytest.mark.parametrize("law", get_args(TimeLaw))
@pytest.mark.parametrize("slow", [LimitsRequest(), LimitsRequest(velocity_scale=0.3, acceleration=20.0, jerk=4000.0)])
def test_at_random_moments_it_brakes_along_the_curve_within_limits(
    law: TimeLaw, slow: LimitsRequest, solved: Plan
) -> None:
    motion = time_path(solved.path, solved.checker, MotionLimits.of(solved.robot, slow), law=law)
    moments = np.random.default_rng(7).uniform(0.0, motion.duration, 40)
    for t in [0.0, *moments.tolist(), motion.duration - 1e-4, motion.duration]:
        braked(motion, t)


def test_it_brakes_as_hard_as_one_joint_allows_on_a_line(solved: Plan) -> None:
    """There it takes v / a of the joint that is at its limit."""
    line = time_path(solved.path[:2], solved.checker)
    assert line.limits is not None
    for share in (0.2, 0.3, 0.4):
        stop, v = line.stop_at(share * line.duration), line.at(share * line.duration, 1)[0]
        quickest = (np.abs(v) / line.limits.acceleration).max()
        assert stop.trajectory.duration == pytest.approx(quickest, abs=5e-3)


def test_without_limits_it_says_so() -> None:
    bare = Trajectory.through(("a",), np.array([0.0, 1.0]), np.array([[0.0], [1.0]]), np.zeros((2, 1)))
    with pytest.raises(PlannerError, match="no limits to brake within"):
        bare.stop_at(0.5)
