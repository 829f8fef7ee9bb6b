"""From the phases of a motion to quintics of limited jerk between knots at whole nanoseconds.

The mean of a motion over the last ``window`` seconds keeps its limits on positions, velocities and accelerations, as
means do, and its jerk is the change of the acceleration over the window by the window: no more than twice the limit on
acceleration by ``window``. It begins and ends at rest where the motion does, ``window`` later (a moving-average filter:
Biagiotti and Melchiorri 2008). On a line the result is still on the line. At a stop the motion waits for a ``window``,
so that the mean reaches the corner itself.

The knots are those of the motion, and ``window`` behind each. The mean's acceleration is continuous, and so is that of
the quintics with its positions, velocities and accelerations at the knots: their jerk is all the jerk that there is. On
lines they are the mean itself, which is a cubic there; on parabolas they are close to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.motion.curve import Curve
from planner.motion.time_optimal import Phase
from planner.motion.trajectory import Trajectory

NANOSECOND = 1e-9
_APART = 50_000  # ns: knots nearer than this are one, for the noise of the jerk between them grows with 1 / h³
_SHORTEST_WINDOW = 1e-3  # s


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
        return Trajectory.through(joints, in_seconds(self.nanoseconds), self.q, self.qd, self.qdd, law=law)


def standstill(q: Floats, nanoseconds: int) -> Timed:
    """A motion that stays at ``q`` (dof,)."""
    rest = np.repeat(q[None], 2, axis=0)
    return Timed(np.array([0, nanoseconds]), rest, 0.0 * rest, np.zeros(1, dtype=int), 0.0 * rest)


def in_seconds(nanoseconds: Ints) -> Floats:
    """Seconds (k,), the same to the last bit wherever they are computed."""
    return np.asarray(nanoseconds / 1e9, dtype=np.float64)


def window_for(acceleration: Floats, jerk: Floats) -> int:
    """Nanoseconds to take the mean over so that no jerk is beyond its limit (dof,)."""
    return int(np.ceil(max(float((2.0 * acceleration / jerk).max()), _SHORTEST_WINDOW) / NANOSECOND))


def knots_of(curve: Curve, phases: list[Phase], stretch: float, window: int) -> Timed:
    """The knots of ``phases``, ``stretch`` times as slow, with a wait of ``window`` ns at every stop on the way."""
    rows: list[tuple[int, Floats, Floats, int]] = []
    clock, start = 0.0, 0
    for k, phase in enumerate(phases):
        begin = start + clock / NANOSECOND
        late = (np.ceil(begin) - begin) * NANOSECOND  # the knot is where the phase is at the next whole nanosecond
        rows.append((int(np.ceil(begin)), *_state(curve, phase, min(late, stretch * phase.duration), stretch)))
        clock += stretch * phase.duration
        last = k + 1 == len(phases)
        if last or (phases[k + 1].piece != phase.piece and curve.stop[phase.piece]):
            start = int(np.ceil(start + clock / NANOSECOND))
            corner = curve.coefficients[phase.piece].sum(axis=0)
            rows.append((start, corner, np.zeros_like(corner), phase.piece))
            clock, start = 0.0, start if last else start + window
    return _without_crowding(rows)


def _state(curve: Curve, phase: Phase, t: float, stretch: float) -> tuple[Floats, Floats, int]:
    """Position, velocity and piece ``t`` s into a phase that is ``stretch`` times as slow."""
    t /= stretch
    s = phase.s + (phase.speed + 0.5 * phase.acceleration * t) * t
    speed = (phase.speed + phase.acceleration * t) / stretch
    c0, c1, c2 = curve.coefficients[phase.piece]
    return c0 + (c1 + c2 * s) * s, (c1 + 2.0 * s * c2) * speed, phase.piece


def _without_crowding(rows: list[tuple[int, Floats, Floats, int]]) -> Timed:
    kept = rows[:1]
    for row in rows[1:]:
        if row[0] - kept[-1][0] >= _APART:
            kept.append(row)
        elif not row[2].any():  # a stop has to stay: take the place of the knot before it
            kept[-1] = (kept[-1][0] if len(kept) == 1 else row[0], *row[1:])
    times, q, qd, piece = zip(*kept, strict=True)
    return Timed(np.array(times), np.array(q), np.array(qd), np.array(piece[:-1]))


def smoothed(timed: Timed, window: int) -> Timed:
    """The mean of the motion over the last ``window`` ns, from its beginning to ``window`` after its end."""
    end = int(timed.nanoseconds[-1])
    times = np.unique(np.concatenate([timed.nanoseconds, timed.nanoseconds + window]))
    times = times[np.concatenate([[True], np.diff(times) >= _APART])]
    times[-1] = end + window
    base = _with_rest(timed, window).trajectory((), "")
    now, before, seconds = in_seconds(times), in_seconds(times - window), window * NANOSECOND
    q, qd, qdd = _means(base, before, now), *((base.at(now, k) - base.at(before, k)) / seconds for k in (0, 1))
    q[0], q[-1] = timed.q[0], timed.q[-1]
    qd[[0, -1]] = qdd[[0, -1]] = 0.0
    piece = np.clip(np.searchsorted(timed.nanoseconds, times[:-1], side="right") - 1, 0, len(timed.piece) - 1)
    return Timed(times, q, qd, timed.piece[piece], qdd)


def _with_rest(timed: Timed, window: int) -> Timed:
    """The motion with a ``window`` of rest before it and after it."""
    times = timed.nanoseconds
    return Timed(
        np.concatenate([[times[0] - window], times, [times[-1] + window]]),
        np.concatenate([timed.q[:1], timed.q, timed.q[-1:]]),
        np.concatenate([0.0 * timed.qd[:1], timed.qd, 0.0 * timed.qd[-1:]]),
        np.concatenate([timed.piece[:1], timed.piece, timed.piece[-1:]]),
    )


def _means(base: Trajectory, low: Floats, high: Floats) -> Floats:
    """Means (n, dof) of the positions from ``low`` to ``high`` (n,): Simpson's rule, exact for cubics, piece by piece.

    Summed up is the difference to the position at ``high``, which is small, so that nothing is lost to rounding.
    """
    at_high = base.at(high)
    total = np.zeros_like(at_high)
    first, last = base.piece_at(low), base.piece_at(high)
    for offset in range(int((last - first).max()) + 1):
        piece = np.minimum(first + offset, last)
        a, b = np.maximum(low, base.times[piece]), np.minimum(high, base.times[piece + 1])
        width = np.where(first + offset <= last, np.maximum(b - a, 0.0), 0.0)
        values = base.at(a) + 4.0 * base.at(a + 0.5 * width) + base.at(a + width) - 6.0 * at_high
        total += width[:, None] / 6.0 * values
    return at_high + total / (high - low)[:, None]
