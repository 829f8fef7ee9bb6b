"""The mean of a motion over a window: against a plain sum over many samples, within the limits, at rest at its ends."""

from __future__ import annotations

import numpy as np
import pytest

from planner.trajectory.curve import rounded
from planner.trajectory.smoothing import Spacing, Timed, knots_of, smoothed, window_for
from planner.trajectory.time_optimal import quickest
from planner.trajectory.trajectory import NANOSECOND

VELOCITY, ACCELERATION, JERK = np.array([1.0, 1.5]), np.array([4.0, 3.0]), np.array([100.0, 60.0])
PATH = np.array([[0.0, 0.0], [0.8, 0.1], [0.9, 0.9], [0.2, 1.0]])


def timed(widths: tuple[float, float]) -> tuple[Timed, Spacing]:
    curve, spacing = rounded(PATH, np.array(widths)), Spacing(window_for(ACCELERATION, JERK), 50_000)
    return knots_of(curve, quickest(curve, VELOCITY, ACCELERATION), 1.0, spacing), spacing


def test_the_window_limits_the_jerk() -> None:
    window = window_for(ACCELERATION, JERK)
    assert (2 * ACCELERATION / (window * NANOSECOND) <= JERK).all()
    assert (2 * ACCELERATION / ((window - 1) * NANOSECOND) > JERK).any()
    assert window_for(np.array([1.0]), np.array([1e9])) * NANOSECOND == pytest.approx(1e-3)


@pytest.mark.parametrize("widths", [(1.0, 1.0), (0.0, 0.5)])
def test_positions_at_the_knots_are_the_mean(widths: tuple[float, float]) -> None:
    motion, spacing = timed(widths)
    base, mean = motion.trajectory(("a", "b"), ""), smoothed(motion, spacing)
    for t, q in zip(mean.nanoseconds / 1e9, mean.q, strict=True):
        times = t - (np.arange(4000) + 0.5) / 4000 * spacing.window * NANOSECOND
        np.testing.assert_allclose(q, base.at(times).mean(axis=0), atol=1e-6)
    assert mean.nanoseconds[-1] == motion.nanoseconds[-1] + spacing.window
    assert not mean.qd[[0, -1]].any()
    made = mean.trajectory(("a", "b"), "")
    for order, limit in ((1, VELOCITY), (2, 1.25 * ACCELERATION)):  # between knots on parabolas it may exceed a little
        assert (made.largest(order) <= limit * (1 + 1e-5)).all()


def test_at_a_stop_the_motion_waits_for_the_window() -> None:
    motion, spacing = timed((0.0, 0.0))
    corner = [k for k, q in enumerate(motion.q) if np.array_equal(q, PATH[1])]
    assert len(corner) >= 1
    assert not motion.qd[corner].any()
    mean = smoothed(motion, spacing)
    assert np.abs(mean.q - PATH[1]).max(axis=1).min() < 1e-12, "the mean reaches the corner itself"
    assert np.diff(motion.nanoseconds).min() >= 10_000
