"""Jumps at the points of a trajectory: where a velocity or an acceleration jumps, the next derivative is infinite."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.trajectory import Trajectory

_LEAST = 1e-6  # of the limit on what jumps: less comes from numbers that were printed and read back
_ROUNDED = 4  # last bits of a position


@dataclass(frozen=True)
class Jump:
    """At ``time`` s a joint's ``what`` (velocity or acceleration) jumps by ``size``, the largest of ``count`` jumps."""

    what: str
    joint: str
    size: float
    time: float
    count: int

    @property
    def infinite(self) -> tuple[str, ...]:
        """The kinds of limits that no number can keep then: acceleration and jerk, or jerk."""
        return KINDS[KINDS.index(self.what) + 1 :]


def largest_jump(trajectory: Trajectory, limits: MotionLimits) -> Jump | None:
    """The largest jump of a velocity, measured by the limits on it; of an acceleration where no velocity jumps.

    In the end the robot stands. So it does before the beginning where it begins at rest; else it may move already.
    None where nothing jumps by more than 1e-6 of the limit, or than rounding may be.
    """
    stands = bool((np.abs(_sides(trajectory, 1)[1][0]) <= _LEAST * limits.velocity).all())
    for order, what in enumerate(KINDS[:2], start=1):
        before, after = _sides(trajectory, order)
        left = np.concatenate([0.0 * after[:1] if stands else after[:1], before])
        size = np.abs(np.concatenate([after, 0.0 * before[-1:]]) - left)
        least = _LEAST * getattr(limits, what) + _noise(trajectory, order)[:, None]
        shares = size / least
        if shares.max() > 1.0:
            k, joint = np.unravel_index(int(shares.argmax()), shares.shape)
            count = int((shares > 1.0).any(axis=1).sum())
            return Jump(what, trajectory.joints[joint], float(size[k, joint]), float(trajectory.times[k]), count)
    return None


def _sides(trajectory: Trajectory, order: int) -> tuple[Floats, Floats]:
    """A derivative at the end and at the beginning of every piece (k, dof): where it is given, one value on both."""
    if order < len(trajectory.columns):
        return trajectory.columns[order][1:], trajectory.columns[order][:-1]
    return trajectory.ends(order)


def _noise(trajectory: Trajectory, order: int) -> Floats:
    """(k + 1,) what rounded positions make of a derivative that is not given, at each point."""
    if order < len(trajectory.columns):
        return np.zeros(len(trajectory.times))
    of_pieces = (2.0, 24.0)[order - 1] * _ROUNDED * np.spacing(np.abs(trajectory.columns[0]).max())
    padded = np.pad(of_pieces / trajectory.seconds**order, 1)
    return padded[:-1] + padded[1:]
