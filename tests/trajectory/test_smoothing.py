"""The mean of a motion over a window: against a plain sum over many samples, within the limits, at rest at its ends."""

from __future__ import annotations

import numpy as np
import pytest

from planner.native.compiled import curve_knots
from planner.trajectory.curve import average_motion, fastest_phases, round_corners, smoothing_window
from planner.trajectory.trajectory import NANOSECOND, Trajectory

VELOCITY, ACCELERATION, JERK = np.array([1.0, 1.5]), np.array([4.0, 3.0]), np.array([100.0, 60.0])
PATH = np.array([[0.0, 0.0], [0.8, 0.1], [0.9, 0.9], [0.2, 1.0]])


def motions(widths: tuple[float, float]) -> tuple[Trajectory, Trajectory, int]:
    """The motion before its mean is taken, its mean, and the window (ns)."""
    curve, spacing = round_corners(PATH, np.array(widths)), (smoothing_window(ACCELERATION, JERK), 50_000)
    phases, (window, apart) = fastest_phases(curve, VELOCITY, ACCELERATION), spacing
    clock, q, qd, _ = curve_knots(curve.coefficients, curve.stop, phases, 1.0, window, apart)
    base = Trajectory(("a", "b"), clock, (q, qd))
    return base, average_motion(curve, phases, 1.0, spacing, ("a", "b"))[0], window


@pytest.mark.parametrize("widths", [(1.0, 1.0), (0.0, 0.5)])
def test_positions_at_the_knots_are_the_mean(widths: tuple[float, float]) -> None:
    base, mean, window = motions(widths)
    for t, q in zip(mean.times, mean.columns[0], strict=True):
        times = t - (np.arange(4000) + 0.5) / 4000 * window * NANOSECOND
        np.testing.assert_allclose(q, base.at(times).mean(axis=0), atol=1e-6)
    assert mean.nanoseconds[-1] == base.nanoseconds[-1] + window
    assert not mean.columns[1][[0, -1]].any()
    for order, limit in ((1, VELOCITY), (2, 1.25 * ACCELERATION)):  # between knots on parabolas it may exceed a little
        assert (mean.largest(order) <= limit * (1 + 1e-5)).all()


def test_at_a_stop_the_motion_waits_for_the_window() -> None:
    base, mean, _ = motions((0.0, 0.0))
    corner = [k for k, q in enumerate(base.columns[0]) if np.array_equal(q, PATH[1])]
    assert len(corner) >= 1
    assert not base.columns[1][corner].any()
    assert np.abs(mean.columns[0] - PATH[1]).max(axis=1).min() < 1e-12, "the mean reaches the corner itself"
    assert np.diff(base.nanoseconds).min() >= 10_000
