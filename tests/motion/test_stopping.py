"""Braking at any moment: from the state that there is, along the same curve, within limits, to rest."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.errors import PlannerError
from planner.motion.timing import time_path
from planner.motion.trajectory import Trajectory
from planner.plan_record import Plan


@pytest.fixture(scope="module")
def motion(solved: Plan) -> Trajectory:
    return time_path(solved.path, solved.checker)


@pytest.mark.parametrize("share", [0.0, 0.05, 0.2, 0.37, 0.5, 0.66, 0.8, 0.95, 1.0])
def test_it_brakes_along_the_curve_within_limits(motion: Trajectory, share: float) -> None:
    assert motion.limits is not None
    t = share * motion.duration
    stop = motion.stop_at(t)
    made = stop.trajectory
    assert stop.excess <= 0.02
    np.testing.assert_allclose(made.at(0.0), motion.at(t), atol=1e-12)
    if 0 < share < 1:
        np.testing.assert_allclose(made.at(0.0, 1), motion.at(t, 1), atol=1e-9)
    assert not made.knots(1)[-1].any()
    np.testing.assert_allclose(made.at(made.duration), motion.at(stop.rest), atol=1e-12)
    assert stop.rest <= motion.duration + 2.1e-3
    assert made.duration <= motion.duration - t + 0.01
    curve = motion.at(np.linspace(t, motion.duration, 20_001))
    for q in made.at(np.linspace(0.0, made.duration, 60)):
        assert np.abs(curve - q).max(axis=1).min() < 2e-4


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
