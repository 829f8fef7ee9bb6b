"""Limits against closed forms, jumps against finite differences on both sides of every point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planner.trajectory.limits import MotionLimits
from planner.trajectory.trajectory import Trajectory
from planner.trajectory.violations import largest_jump, limits_exceeded
from tests.trajectory.test_export import ARM, MADE

LIMITS = MotionLimits.of(ARM)
TIMES = np.array([0.0, 0.3, 0.45, 1.1, 1.9])
RNG = np.random.default_rng(5)
Q = RNG.normal(size=(5, 2))
QD = np.concatenate([np.zeros((1, 2)), RNG.normal(size=(3, 2)), np.zeros((1, 2))])


@pytest.mark.parametrize(("columns", "what", "order"), [((Q,), "velocity", 1), ((Q, QD), "acceleration", 2)])
def test_the_largest_is_the_one_that_differences_find(columns: tuple, what: str, order: int) -> None:
    made = Trajectory.through(ARM.joints, TIMES, *columns)
    apart = 1e-7
    before, after = (made.at(TIMES + sign * apart, order) for sign in (-1, 1))
    after[-1] = 0.0  # it stands then
    before[0] = after[0] if what == "velocity" else 0.0
    size = np.abs(after - before)
    k, joint = np.unravel_index(int((size / getattr(LIMITS, what)).argmax()), size.shape)
    jump = largest_jump(made, LIMITS)
    assert jump is not None
    assert (jump.what, jump.joint, jump.time) == (what, ARM.joints[joint], TIMES[k])
    assert jump.size == pytest.approx(size[k, joint], rel=1e-4)
    assert jump.count == (size > 1e-3).any(axis=1).sum()
    assert jump.infinite == ("acceleration", "jerk")[order - 1 :]


def test_what_we_make_does_not_jump_and_standing_does_not_either() -> None:
    assert largest_jump(MADE, LIMITS) is None
    still = np.repeat(Q[:1], 5, axis=0)
    for columns in ((still,), (still, 0.0 * still)):
        assert largest_jump(Trajectory.through(ARM.joints, TIMES, *columns), LIMITS) is None


def test_a_straight_line_of_many_points_jumps_at_its_ends_only() -> None:
    """Rounded positions 1 ms apart are no jumps of velocities, nor of the accelerations of cubics."""
    t = np.arange(2001) / 1000.0
    q = np.stack([3.0 + 0.1 * t, 1.0 - 0.2 * t], axis=1)
    jump = largest_jump(Trajectory.through(ARM.joints, t, q), LIMITS)
    assert jump is not None
    assert (jump.time, jump.count) == (2.0, 1), "before it begins the robot may move already"
    qd = np.repeat([[0.1, -0.2]], len(t), axis=0)
    qd[-1] = 0.0
    jump = largest_jump(Trajectory.through(ARM.joints, t, q, qd), LIMITS)
    assert jump is not None
    assert jump.count == 2, "those of the last piece, which brakes within a millisecond"


def test_an_end_that_still_accelerates_jumps() -> None:
    bent = MADE.columns[2].copy()
    bent[-1] = [0.0, 1.0]
    jump = largest_jump(replace(MADE, columns=(*MADE.columns[:2], bent)), LIMITS)
    assert jump is not None
    assert (jump.what, jump.joint, jump.size, jump.time) == ("acceleration", ARM.joints[1], 1.0, MADE.times[-1])


def test_every_kind_of_limit_is_judged_by_exact_extrema() -> None:
    """A cubic from rest to rest over 1 rad in T s: velocity 1.5 / T, acceleration 6 / T², jerk 12 / T³."""
    for T in (0.3, 3.0):
        q = np.array([[0.0, 0.0], [1.0, 0.0]])
        made = Trajectory.through(ARM.joints, np.array([0.0, T]), q, np.zeros((2, 2)))
        broken = {each.what[0]: each.value for each in limits_exceeded(made, ARM, LIMITS)}
        truth = {"velocity": 1.5 / T, "acceleration": 6 / T**2, "jerk": 12 / T**3}
        assert broken == pytest.approx({k: v for k, v in truth.items() if v > getattr(LIMITS, k)[0]}, rel=1e-9)
    outside = Trajectory.through(ARM.joints, np.array([0.0, 9.0]), np.array([[0.0, 0], [0.0, 9.0]]), np.zeros((2, 2)))
    (found,) = (each for each in limits_exceeded(outside, ARM, LIMITS) if each.what[0] == "position")
    assert (found.kind, found.what[1], found.value, found.allowed) == ("limit", ARM.joints[1], 9.0, ARM.upper[1])
