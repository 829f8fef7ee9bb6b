"""What a controller rebuilds from exported points, by rational numbers: no rounding but that of what is printed."""

from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np

from planner.trajectory.limits import KINDS, MotionLimits

_COLUMNS = ("positions", "velocities", "accelerations")


def largest_shares(message: dict[str, Any], limits: MotionLimits) -> dict[str, float]:
    """The largest share of each limit on the quintics between the points of a JointTrajectory as plain data."""
    clock = [1_000_000_000 * p["time_from_start"]["sec"] + p["time_from_start"]["nanosec"] for p in message["points"]]
    rows = [[[Fraction(value) for value in point[key]] for key in _COLUMNS] for point in message["points"]]
    lengths = [Fraction(late - early, 1_000_000_000) for early, late in pairwise(clock)]
    pieces = [
        [[float(c) for c in _quintic(h, *joint)] for joint in zip(*first, *last, strict=True)]
        for h, first, last in zip(lengths, rows, rows[1:], strict=False)
    ]
    powers, h = np.swapaxes(np.array(pieces), 1, 2), np.array(lengths, dtype=float)[:, None]  # of u, to the last bit
    shares = {}
    for order, kind in enumerate(KINDS, start=1):
        powers = powers[:, 1:] * np.arange(1, powers.shape[1])[:, None]
        largest = np.array([[_largest(c) for c in piece.T] for piece in powers])
        shares[kind] = float((largest / h**order / getattr(limits, kind)).max())
    return shares


def _largest(c: np.ndarray) -> float:
    """The largest absolute value on [0, 1], by the roots of the derivative as eigenvalues."""
    slope = np.trim_zeros(c[1:] * np.arange(1, len(c)), "b")
    roots = np.polynomial.polynomial.polyroots(slope) if len(slope) else np.zeros(0)
    places = [0.0, 1.0, *(float(np.clip(root.real, 0.0, 1.0)) for root in roots)]
    return float(np.abs(np.polynomial.polynomial.polyval(places, c)).max())


def _quintic(h: Fraction, q0: Fraction, v0: Fraction, a0: Fraction, q1: Fraction, v1: Fraction, a1: Fraction):
    """Coefficients of u = t / h by the six conditions at u = 0 and 1."""
    start, end, bend, bent = v0 * h, v1 * h, a0 * h * h, a1 * h * h
    third = 10 * (q1 - q0) - 6 * start - 4 * end - (3 * bend - bent) / 2
    fourth = 15 * (q0 - q1) + 8 * start + 7 * end + (3 * bend - 2 * bent) / 2
    fifth = 6 * (q1 - q0) - 3 * (start + end) - (bend - bent) / 2
    return q0, start, bend / 2, third, fourth, fifth
