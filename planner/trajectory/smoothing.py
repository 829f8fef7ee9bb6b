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
from planner.trajectory.curve import Curve
from planner.trajectory.limits import KINDS, LEAST_JERK, MotionLimits
from planner.trajectory.time_optimal import Phase
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


_Row = tuple[int, Floats, Floats, int]  # nanoseconds, position, velocity, piece


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


def knots_of(curve: Curve, phases: list[Phase], stretch: float, spacing: Spacing) -> Timed:
    """The knots of ``phases``, ``stretch`` times as slow, with a wait of a window at every stop on the way.

    Between two stops a motion takes four times as long as knots are apart, or longer.
    """
    rows: list[_Row] = []
    begin = 0
    for section in _sections(curve, phases):
        found, end = _knots_between_stops(curve, section, stretch, begin, spacing.apart)
        rows += found
        begin = end + spacing.window
    times, q, qd, piece = zip(*rows, strict=True)
    return Timed(np.array(times), np.array(q), np.array(qd), np.array(piece[:-1]))


def _sections(curve: Curve, phases: list[Phase]) -> list[list[Phase]]:
    """The phases from stop to stop."""
    sections: list[list[Phase]] = [[]]
    for phase in phases:
        last = sections[-1][-1:]
        if last and last[0].piece != phase.piece and curve.stop[last[0].piece]:
            sections.append([])
        sections[-1].append(phase)
    return sections


def _knots_between_stops(
    curve: Curve, phases: list[Phase], stretch: float, begin: int, apart: int
) -> tuple[list[_Row], int]:
    """The knots from rest at ``begin`` ns to rest, and when that is: those that are ``apart`` from one another."""
    rows: list[_Row] = []
    end, late = begin, 0.0  # a phase begins ``late`` s before the whole nanosecond ``end``, at which its knot is
    for phase in phases:
        takes = stretch * phase.duration
        if not rows or end - rows[-1][0] >= apart:
            rows.append((end, *_state(curve, phase, min(late, takes), stretch)))
        more = ceil((takes - late) / NANOSECOND)
        end, late = end + more, more * NANOSECOND - (takes - late)
    rows = rows[:1] if end - begin < 4 * apart else [row for row in rows if row is rows[0] or end - row[0] >= apart]
    end = max(end, begin + 4 * apart)
    corner = curve.coefficients[phases[-1].piece].sum(axis=0)
    return [*rows, (end, corner, np.zeros_like(corner), phases[-1].piece)], end


def _state(curve: Curve, phase: Phase, t: float, stretch: float) -> tuple[Floats, Floats, int]:
    """Position, velocity and piece ``t`` s into a phase that is ``stretch`` times as slow."""
    t /= stretch
    s = phase.s + (phase.speed + 0.5 * phase.acceleration * t) * t
    speed = (phase.speed + phase.acceleration * t) / stretch
    c0, c1, c2 = curve.coefficients[phase.piece]
    return c0 + (c1 + c2 * s) * s, (c1 + 2.0 * s * c2) * speed, phase.piece


def smoothed(timed: Timed, spacing: Spacing) -> Timed:
    """The mean of the motion over the last window, from its beginning to a window after its end."""
    window = spacing.window
    times = _thinned(np.unique(np.concatenate([timed.nanoseconds, timed.nanoseconds + window])), spacing.apart)
    base = _with_rest(timed, window).trajectory((), "")
    before, seconds = times - window, window * NANOSECOND
    change = [base.at_nanoseconds(times, k) - base.at_nanoseconds(before, k) for k in (0, 1)]
    q, qd, qdd = _means(base, before, times), *(values / seconds for values in change)
    q[0], q[-1] = timed.q[0], timed.q[-1]
    qd[[0, -1]] = qdd[[0, -1]] = 0.0
    piece = np.clip(np.searchsorted(timed.nanoseconds, times[:-1], side="right") - 1, 0, len(timed.piece) - 1)
    return Timed(times, q, qd, timed.piece[piece], qdd)


def _thinned(times: Ints, apart: int) -> Ints:
    """The times (k,) without those nearer than ``apart`` to the one before that is left, or to the last, which is."""
    kept = times[:1].tolist()
    for time in times[1:-1].tolist():
        if time - kept[-1] >= apart and times[-1] - time >= apart:
            kept.append(time)
    return np.array([*kept, times[-1]], dtype=np.int64)


def _with_rest(timed: Timed, window: int) -> Timed:
    """The motion with a ``window`` of rest before it and after it."""
    times = timed.nanoseconds
    return Timed(
        np.concatenate([[times[0] - window], times, [times[-1] + window]]),
        np.concatenate([timed.q[:1], timed.q, timed.q[-1:]]),
        np.concatenate([0.0 * timed.qd[:1], timed.qd, 0.0 * timed.qd[-1:]]),
        np.concatenate([timed.piece[:1], timed.piece, timed.piece[-1:]]),
    )


def _means(base: Trajectory, low: Ints, high: Ints) -> Floats:
    """Means (n, dof) of the positions from ``low`` to ``high`` (n,) ns: Simpson's rule, exact for cubics, by pieces.

    Summed up is the difference to the position at ``high``, which is small, so that nothing is lost to rounding.
    """
    at_high = base.at_nanoseconds(high)
    total = np.zeros_like(at_high)
    first, last = base.piece_at(low), base.piece_at(high)
    for offset in range(int((last - first).max()) + 1):
        piece = np.minimum(first + offset, last)
        begin = base.nanoseconds[piece]
        a, b = np.maximum(low, begin), np.minimum(high, base.nanoseconds[piece + 1])
        width = np.where(first + offset <= last, np.maximum(b - a, 0), 0) / 1e9
        since = (a - begin) / 1e9
        values = base.on(piece, since) + 4.0 * base.on(piece, since + 0.5 * width) + base.on(piece, since + width)
        total += width[:, None] / 6.0 * (values - 6.0 * at_high)
    return at_high + total / ((high - low) / 1e9)[:, None]
