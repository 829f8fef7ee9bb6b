"""From the phases of a motion to quintics of limited jerk between knots at whole nanoseconds.

The mean of a motion over the last ``window`` seconds keeps its limits on positions, velocities and accelerations, as
means do, and its jerk is the change of the acceleration over the window by the window: no more than twice the limit on
acceleration by ``window``. It begins and ends at rest where the motion does, ``window`` later (a moving-average filter:
Biagiotti and Melchiorri 2008). On a line the result is still on the line. At a stop the motion waits for a ``window``,
so that the mean reaches the corner itself.

The knots are those of the motion, and ``window`` behind each. The mean's acceleration is continuous, and so is that of
the quintics with its positions, velocities and accelerations at the knots: their jerk is all the jerk that there is. On
lines they are the mean itself, which is a cubic there; on parabolas they are close to it.

Positions are doubles: of what they are rounded by between two knots, h apart, quintics make a jerk of 60 / h³ of it. So
knots keep apart by as much as the limits ask for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.native.compiled import curve_knots, motion_mean
from planner.trajectory.curve import Curve
from planner.trajectory.limits import KINDS, LEAST_JERK, MotionLimits
from planner.trajectory.time_optimal import Phases
from planner.trajectory.trajectory import NANOSECOND, Trajectory

_ROUNDED = 4  # last bits of a position: the difference of two knots is known no better
_SHARE = 1e-3  # of a limit: what rounding may take
_NEAREST = 50_000  # ns: no knots are nearer than this
_SHORTEST_WINDOW = 1e-3  # s


@dataclass(frozen=True)
class Spacing:
    """Nanoseconds: the ``window`` over which the mean is taken, and how far knots are ``apart`` at least."""

    window: int
    apart: int

    @staticmethod
    def of(limits: MotionLimits, q: Floats) -> Spacing:
        """The shortest ones that limits ask for, along positions (k, dof)."""
        apart = apart_for(limits, q)
        return Spacing(max(window_for(limits.acceleration, limits.jerk), 4 * apart), apart)


def apart_for(
    limits: MotionLimits, q: Floats, kinds: Sequence[str] = KINDS, nearest: int = _NEAREST, share: float = _SHARE
) -> int:
    """Nanoseconds between knots, ``nearest`` or more, so that rounded positions (k, dof) take a ``share`` of no limit.

    Of those on the first ``kinds``.
    """
    noise = _ROUNDED * np.spacing(np.abs(q).max(axis=0))
    shares = [
        (most * noise / (share * getattr(limits, kind))).max() ** (1 / order)
        for order, (kind, most) in enumerate(zip(kinds, LEAST_JERK, strict=False), 1)
    ]
    return max(nearest, ceil(max(shares) / NANOSECOND))


@dataclass(frozen=True, eq=False)
class Timed:
    """The knots of a motion along a curve: ``nanoseconds`` (k,), positions and velocities (k, dof) there.

    ``piece`` (k - 1,) is the curve's piece that the motion is on after each knot. ``qdd`` (k, dof) are accelerations,
    None where they jump.
    """

    nanoseconds: Ints
    q: Floats
    qd: Floats
    piece: Ints
    qdd: Floats | None = None

    def trajectory(self, joints: tuple[str, ...], law: str) -> Trajectory:
        """The quintics between the knots, cubics where no accelerations are known."""
        return Trajectory(joints, self.nanoseconds, self.columns, law)

    @property
    def columns(self) -> tuple[Floats, ...]:
        return (self.q, self.qd) if self.qdd is None else (self.q, self.qd, self.qdd)


def standstill(q: Floats, nanoseconds: int) -> Timed:
    """A motion that stays at ``q`` (dof,)."""
    rest = np.repeat(q[None], 2, axis=0)
    return Timed(np.array([0, nanoseconds]), rest, 0.0 * rest, np.zeros(1, dtype=int), 0.0 * rest)


def window_for(acceleration: Floats, jerk: Floats) -> int:
    """Nanoseconds to take the mean over so that no jerk is beyond its limit (dof,)."""
    return int(np.ceil(max(float((2.0 * acceleration / jerk).max()), _SHORTEST_WINDOW) / NANOSECOND))


def knots_of(curve: Curve, phases: Phases, stretch: float, spacing: Spacing) -> Timed:
    """The knots of ``phases``, ``stretch`` times as slow, with a wait of a window at every stop on the way.

    Between two stops a motion takes four times as long as knots are apart, or longer.
    """
    window, apart = spacing.window, spacing.apart
    clock, q, qd, piece = curve_knots(curve.coefficients, curve.stop, phases.rows, stretch, window, apart)
    return Timed(clock, q, qd, piece[:-1])


def smoothed(timed: Timed, spacing: Spacing) -> Timed:
    """The mean of the motion over the last window, from its beginning to a window after its end."""
    clock, q, qd, qdd = motion_mean(timed.nanoseconds, timed.q, timed.qd, spacing.window, spacing.apart)
    piece = np.clip(np.searchsorted(timed.nanoseconds, clock[:-1], side="right") - 1, 0, len(timed.piece) - 1)
    return Timed(clock, q, qd, timed.piece[piece], qdd)
