"""What the compiled library knows of curves of parabolas and of motions along them: one function for each thing.

Arrays are float64 in C order unless Ints, angles rad, lengths m, times s unless ns. :class:`ArrayError` where arrays
are not of the shapes that stand here, or hold what the library cannot use.
"""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.native.loading import address as _at
from planner.native.loading import flags as _bytes
from planner.native.loading import floats as _floats
from planner.native.loading import ints as _ints
from planner.native.loading import library as _library
from planner.native.world import NativeBounds, NativeWorld

Place = tuple[int, float]  # a piece of a curve, and s on it
Ramp = tuple[int, Place, Place, Floats]  # its number among those tried, both ends on the curve, pieces (m, 3, dof)


def polynomial_extrema(coefficients: Floats) -> tuple[Floats, Floats]:
    """The least and largest values (n, dof) on [0, 1] of polynomials (n, degree + 1, dof), exact but for rounding."""
    coefficients = _floats(coefficients)
    n, count, dof = coefficients.shape
    least, largest = np.empty((n, dof)), np.empty((n, dof))
    _library.polynomials_extrema(n, count - 1, dof, _at(coefficients), _at(least), _at(largest))
    return least, largest


def polynomial_worst(
    coefficients: Floats, seconds: Floats, order: int, most: Floats, beyond: float
) -> tuple[float, int, int]:
    """The largest share that a derivative by time has of limits ``most`` (dof,), and which piece and joint has it.

    Pieces (n, degree + 1, dof) take ``seconds`` (n,). Shares up to ``beyond`` may come out smaller than they are.
    """
    coefficients = _floats(coefficients)
    n, count, dof = coefficients.shape
    seconds, most, where = _floats(seconds, n), _floats(most, dof), np.empty(2, dtype=np.int64)
    share = _library.polynomials_worst(
        n, count - 1, dof, order, _at(coefficients), _at(seconds), _at(most), beyond, _at(where)
    )
    return share, int(where[0]), int(where[1])


def curve_phases(pieces: Floats, stop: Bools, intervals: Ints, velocity: Floats, acceleration: Floats) -> Floats:
    """The phases (p, 5) of the quickest motion from rest to rest along ``pieces`` (m, 3, dof), c0 + c1 s + c2 s².

    A phase is a piece, s and ds/dt at its beginning, d²s/dt² on it, and the seconds that it takes. The motion stops
    behind pieces with ``stop`` (m,); on a parabola d²s/dt² is constant on each of its ``intervals`` (m,). Limits are
    (dof,).
    """
    m, dof = len(pieces), len(velocity)
    pieces, stop, intervals = _floats(pieces, m, 3, dof), _bytes(stop, m), _ints(intervals, m)
    limits, phases = (_floats(velocity, dof), _floats(acceleration, dof)), np.empty((int(intervals.sum()) + 3 * m, 5))
    count = _library.curve_phases(dof, m, _at(pieces), _at(stop), _at(intervals), *map(_at, limits), _at(phases))
    return phases[:count]


def curve_knots(
    pieces: Floats, stop: Bools, phases: Floats, stretch: float, window: int, apart: int
) -> tuple[Ints, Floats, Floats, Ints]:
    """The knots of a motion through ``phases`` (p, 5), ``stretch`` times as slow, no two nearer than ``apart`` ns.

    With a wait of ``window`` ns at every stop on the way; between two stops a motion takes four times ``apart`` or
    longer. Nanoseconds (k,), positions and velocities (k, dof), and the piece (k,) behind each.
    """
    m, p, dof = len(pieces), len(phases), pieces.shape[2]
    pieces, stop, phases = _floats(pieces, m, 3, dof), _bytes(stop, m), _floats(phases, p, 5)
    clock, piece = np.empty(2 * p, dtype=np.int64), np.empty(2 * p, dtype=np.int64)
    q, qd = np.empty((2 * p, dof)), np.empty((2 * p, dof))
    count = _library.curve_knots(
        dof, m, _at(pieces), _at(stop), p, _at(phases), stretch, window, apart, *map(_at, (clock, q, qd, piece))
    )
    return clock[:count], q[:count], qd[:count], piece[:count]


def motion_mean(clock: Ints, q: Floats, qd: Floats, window: int, apart: int) -> tuple[Ints, Floats, Floats, Floats]:
    """The mean over the last ``window`` ns of the cubics through points (k, dof) at ``clock`` (k,) ns.

    It rests before and behind them. At the points and ``window`` later, but none nearer than ``apart`` to another:
    nanoseconds (n,), positions, velocities and accelerations (n, dof).
    """
    k, dof = q.shape
    clock, q, qd = _ints(clock, k), _floats(q, k, dof), _floats(qd, k, dof)
    times, (mean, slope, bend) = np.empty(2 * k, dtype=np.int64), (np.empty((2 * k, dof)) for _ in range(3))
    count = _library.motion_mean(
        k, dof, _at(clock), _at(q), _at(qd), window, apart, *map(_at, (times, mean, slope, bend))
    )
    return times[:count], mean[:count], slope[:count], bend[:count]


def ramp_quickest(
    start: tuple[Floats, Floats],
    end: tuple[Floats, Floats],
    durations: Floats,
    velocity: Floats,
    acceleration: Floats,
) -> Floats:
    """The parabolic ramp (m, 3, dof) between two states, position and velocity (dof,) each; m is 0 where none is.

    In the first of ``durations`` (n,), ascending, in which every joint can within its limits (dof,).
    """
    dof, durations = len(velocity), _floats(durations, len(durations))
    states = [_floats(part, dof) for part in (*start, *end)]
    limits, pieces = (_floats(velocity, dof), _floats(acceleration, dof)), np.empty((2 * dof + 1, 3, dof))
    count = _library.ramp_quickest(
        dof, *map(_at, states), len(durations), _at(durations), *map(_at, limits), _at(pieces)
    )
    return pieces[:count]


def motion_shares(clock: Ints, q: Floats, qd: Floats, qdd: Floats, limits: Floats) -> Floats:
    """The largest shares (3,) of ``limits`` (3, dof) on velocity, acceleration and jerk that a motion has.

    Of quintics through positions, velocities and accelerations (k, dof) at ``clock`` (k,) ns. Those up to 1 may come
    out smaller.
    """
    k, dof = q.shape
    clock, columns = _ints(clock, k), [_floats(column, k, dof) for column in (q, qd, qdd)]
    limits, shares = _floats(limits, 3, dof), np.empty(3)
    _library.motion_shares(k, dof, _at(clock), *map(_at, columns), _at(limits), _at(shares))
    return shares


def curve_chords(curve: Floats, each: int, chord: float) -> tuple[Floats, Floats]:
    """Points (k, dof) of a curve (m, 3, dof), about ``chord`` apart or farther, from its beginning to its end.

    With what is walked (k - 1,) from one to the next, along ``each`` chords a piece.
    """
    m, dof = len(curve), curve.shape[2]
    curve = _floats(curve, m, 3, dof)
    points, walked = np.empty((m * each + 1, dof)), np.empty(m * each)
    count = _library.curve_chords(dof, m, _at(curve), each, chord, _at(points), _at(walked))
    return points[:count], walked[: count - 1]


def curve_next_ramp(
    world: NativeWorld,
    bounds: NativeBounds,
    room: float,
    curve: Floats,
    phases: Floats,
    moments: Floats,
    shares: Floats,
    limits: tuple[Floats, Floats],
    positions: tuple[Floats, Floats],
) -> Ramp | None:
    """The first of pairs of ``moments`` (n, 2) s of a motion through ``phases`` (p, 5) that a proven ramp joins.

    In the first of ``shares`` (k,), ascending, of the time between them, within ``limits`` on velocities and
    accelerations (dof,), and on ``positions``, lowest and highest (dof,). Its number, the piece of the ``curve``
    (m, 3, dof) and s there of both ends, and the ramp; None where there is none, or a stop is asked for.
    """
    m, p, n, dof = len(curve), len(phases), len(moments), world.dof
    curve, phases, moments = _floats(curve, m, 3, dof), _floats(phases, p, 5), _floats(moments, n, 2)
    shares, allowed = _floats(shares, len(shares)), [_floats(array, dof) for array in (*limits, *positions)]
    found, s, pieces = np.empty(3, dtype=np.int64), np.empty(2), np.empty((2 * dof + 1, 3, dof))
    count = _library.world_next_ramp(
        world.handle, *bounds.addresses, room, m, _at(curve), p, _at(phases), n, _at(moments), len(shares), _at(shares),
        *map(_at, (*allowed, found, s, pieces)),
    )  # fmt: skip
    if not count:
        return None
    (first, low), (last, high) = zip(found[1:].tolist(), s.tolist(), strict=True)
    return int(found[0]), (first, low), (last, high), pieces[:count]


def stops_quickest(
    states: Floats, times: Floats, limits: Floats, positions: tuple[Floats, Floats]
) -> tuple[Floats, Floats, Ints]:
    """Stops (n, 2, 5, dof), pieces c0 + c1 u + ... from ``states`` (n, 3, dof), positions, velocities, accelerations.

    v (1 - 3 u^2 + 2 u^3) + a T (u - 2 u^2 + u^3) is the velocity of the second: it ends at rest, without acceleration.
    T is the first of ascending ``times`` (k,) in which no joint exceeds ``limits`` (3, dof) on velocity, acceleration
    and jerk, infinite where there is none, nor ``positions``, lowest and highest (dof,). Where there is no such T the
    first piece lets a fall to 0 evenly, by the largest jerk; else it takes 0 s. With the seconds (n, 2) of both, 0
    where there is no stop: then (n, 2) says which kind of limit is in the way, 3 for positions, and of which joint.
    """
    n, _, dof = states.shape
    states, times, limits = _floats(states, n, 3, dof), _floats(times, len(times)), _floats(limits, 3, dof)
    lower, upper = (_floats(bound, dof) for bound in positions)
    pieces, seconds, broken = np.empty((n, 2, 5, dof)), np.empty((n, 2)), np.empty((n, 2), dtype=np.int64)
    _library.stops_quickest(
        n, dof, _at(states), len(times), *map(_at, (times, limits, lower, upper, pieces, seconds, broken))
    )
    return pieces, seconds, broken


def chunk_curves(
    coefficients: Floats, times: Floats, stops: tuple[Floats, Floats] | None, approach: Floats | None
) -> tuple[Floats, Floats, Ints]:
    """Pieces (n, degree + 1, dof) between ``times`` (n + 1,) s, each with its stop behind it, as curves of one degree.

    ``stops``, pieces and seconds, as :func:`stops_quickest` has them, if any. ``approach`` (2, dof) leads to the first
    point, if it is given. The curves (m, most + 1, dof); their spans (m, 3): when each begins, how long it takes, 0;
    and rows (m, 2): of which piece each is, and 0 for the approach, 1 for a piece, 2 for a stop.
    """
    n, powers, dof = coefficients.shape
    coefficients, times = _floats(coefficients), _floats(times, n + 1)
    most = powers if stops is None else max(powers, 5)
    given = (None, None) if stops is None else (_floats(stops[0], n, 2, 5, dof), _floats(stops[1], n, 2))
    given = *given, None if approach is None else _floats(approach, 2, dof)
    room = 1 + (n if stops is None else 3 * n)
    curves, spans, what = np.empty((room, most, dof)), np.empty((room, 3)), np.empty((room, 2), dtype=np.int64)
    m = _library.chunk_curves(
        n, powers - 1, most - 1, dof, _at(coefficients), _at(times),
        *(None if array is None else _at(array) for array in given), _at(curves), _at(spans), _at(what),
    )  # fmt: skip
    return curves[:m], spans[:m], what[:m]
