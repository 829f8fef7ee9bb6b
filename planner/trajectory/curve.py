"""Curves with rounded corners, their time-optimal motion, shortcuts in time, and jerk smoothing.

**Time-optimal motion** (TOPP-RA: Pham and Pham 2018). Along a piece q(s) the joint acceleration is q' u + q'' x with u
= d²s/dt² and x = (ds/dt)², dx/ds = 2 u. On a grid within the pieces u is constant, so x is linear in s; q' is linear
and q'' constant, so every joint's acceleration is linear in s: limits that hold at both ends of an interval hold on all
of it. A backward pass computes the largest x from which the rest can be done, a forward pass takes the largest u that
stays below it. A velocity limit bounds x by the square of v / q', which is not linear: between the ends of an interval
x stays below a chord of it, so that 24 intervals per corner come within 0.4 % of 800. Lines need no grid.

**Smoothing** (a moving-average filter: Biagiotti and Melchiorri 2008). The mean of a motion over the last ``window``
seconds keeps the motion's limits on positions, velocities and accelerations, and its jerk is at most twice the
acceleration limit divided by ``window``. It starts and ends at rest with the motion, ``window`` later. A mean on a line
stays on the line. At a stop the motion waits for a ``window``, so that the mean reaches the corner itself. The knots
are those of the motion, and ``window`` after each. Quintics run through these knots: on lines they equal the mean, on
parabolas they are close to it.

Positions are doubles: quintics turn a rounding error of a position into a jerk of 60 / h³ times the error between knots
h apart. The limits therefore set a least time between knots.

**Shortcuts** (Hauser and Ng-Thow-Hing 2010). Between two states of the motion (position and velocity) every joint takes
its own parabolic ramp, all of the same duration. A ramp replaces the motion between the states if it is faster, is
proven to keep the margin and the manipulability floor, and leaves the cost of the whole curve within its bound. Ramps
are parabolas, as rounded corners are, so the same method finds the time-optimal motion along the new curve.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.polynomials import part
from planner.collision.edge_prover import EdgeProver
from planner.collision.path_moves import next_ramp
from planner.constraints.floor import prove_floor
from planner.native.compiled import curve_chords, curve_knots, curve_phases, motion_mean
from planner.query.resolve import position_bounds
from planner.trajectory.limits import KINDS, LEAST_JERK, MotionLimits
from planner.trajectory.trajectory import NANOSECOND, Trajectory

CurvePoint = tuple[int, float]  # a piece of a curve, and s on it
_CORNER, _RAMP = 24, 3  # intervals per parabola of a corner and of a ramp: s of a ramp is time, so u stays near 0
_ROUNDED = 4  # last bits of a position: the rounding error of the difference of two knots
_SHARE = 1e-3  # of a limit: the share that rounding may use
_NEAREST = 50_000  # ns: the shortest time between knots
_SHORTEST_WINDOW = 1e-3  # s
_SHORTEST = 1e-6  # rad (m): a shorter segment counts as no motion
_REST = 1e-6  # of a piece: a shorter remainder is dropped
TRIES = 60  # twice as many make motions 2 % shorter and their timing 1.6 times as slow
_SHARES = np.linspace(0.3, 0.98, 35)  # durations of a ramp, as shares of the time that it replaces
_SHORTEST_SPAN = 0.05  # of the motion: the shortest stretch that a ramp replaces
_POINTS = 16  # samples per piece, for its length
_CHORD = 0.1  # rad (m): least length of the chords along which the cost is measured
_LEAST = 1e-12  # rad (m)
_STILL = 1e-9  # of the velocity at a ramp's other end: below it the ramp rests there


@dataclass(frozen=True, eq=False)
class Curve:
    """Pieces q(s) = c0 + c1 s + c2 s², s in [0, 1]; each continues the last one in its direction.

    ``coefficients`` (m, 3, dof). ``corner`` (m,) is the waypoint whose corner a piece rounds, -1 for other pieces.
    Where ``stop`` (m,) is true the direction changes at the end of the piece, and the motion stops there.
    """

    coefficients: Floats
    corner: Ints
    stop: Bools


def drop_standstills(path: Floats) -> Floats:
    """Return the path (k, dof) without waypoints that repeat the one before; start and goal remain.

    A path that does not move at all becomes one configuration.
    """
    rows = [0]
    for k in range(1, len(path)):
        if np.abs(path[k] - path[rows[-1]]).max() > _SHORTEST:
            rows.append(k)
    rows[-1] = len(path) - 1 if len(rows) > 1 else 0
    return path[rows]


def path_segments(path: Floats) -> Floats:
    """Return the segments of a path (k, dof) as pieces (k - 1, 3, dof)."""
    delta = np.diff(path, axis=0)
    return np.stack([path[:-1], delta, np.zeros_like(delta)], axis=1)


def corner_parabolas(path: Floats, widths: Floats) -> Floats:
    """Return the parabolas (k - 2, 3, dof) that round the inner waypoints of a path (k, dof).

    Each leaves the segment before its waypoint, and joins the next one, at a share ``widths`` (k - 2,) in [0, 1] of
    half the segment. Bézier control points there and at the waypoint make it tangent to both segments.
    """
    before, at, behind = path[:-2], path[1:-1], path[2:]
    start = at + 0.5 * widths[:, None] * (before - at)
    end = at + 0.5 * widths[:, None] * (behind - at)
    return np.stack([start, 2.0 * (at - start), start - 2.0 * at + end], axis=1)


def round_corners(path: Floats, widths: Floats) -> Curve:
    """Return the path (k, dof) with corners rounded by ``widths`` (k - 2,); 0 is a stop at the corner."""
    if len(path) == 1:
        return Curve(np.stack([path, 0 * path, 0 * path], axis=1), np.array([-1]), np.array([True]))
    parabolas, pieces, corner, stop = corner_parabolas(path, widths), [], [], []
    for k, (start, end) in enumerate(itertools.pairwise(path)):
        first = 0.5 * widths[k - 1] if k > 0 else 0.0
        last = 0.5 * widths[k] if k < len(widths) else 0.0
        low, high = start + first * (end - start), end - last * (end - start)
        if first + last < 1.0:
            pieces.append(np.stack([low, high - low, np.zeros_like(low)]))
            corner.append(-1)
            stop.append(k < len(widths) and widths[k] == 0.0)
        if k < len(widths) and widths[k] > 0.0:
            pieces.append(parabolas[k])
            corner.append(k + 1)
            stop.append(False)
    stop[-1] = True
    return Curve(frozen(pieces), frozen(corner, np.int64), frozen(stop, np.bool_))


def splice(curve: Curve, start: CurvePoint, pieces: Floats, end: CurvePoint) -> Curve:
    """Return the curve with ``pieces`` (m, 3, dof) in place of its stretch from ``start`` to ``end``.

    The pieces have to start and end there in the curve's directions, or at rest.
    """
    (first, low), (last, high) = start, end
    head = np.arange(first + (low > _REST))
    tail = np.arange(last + (high >= 1.0 - _REST), len(curve.corner))
    before, after = curve.coefficients[head], curve.coefficients[tail]
    stop_before, stop_after = curve.stop[head], curve.stop[tail]
    if low > _REST:
        before[-1:] = part(before[-1:], np.zeros(1), np.array([low]))
        stop_before[-1:] = low >= 1.0 and curve.stop[first]
    if high < 1.0 - _REST:
        after[:1] = part(after[:1], np.array([high]), np.ones(1))
    coefficients = np.concatenate([before, pieces, after])
    corner = np.concatenate([curve.corner[head], np.full(len(pieces), -1), curve.corner[tail]])
    stop = np.concatenate([stop_before, np.zeros(len(pieces), dtype=bool), stop_after])
    if high >= 1.0 - _REST:
        stop[len(before) + len(pieces) - 1] = curve.stop[last]
    return Curve(frozen(coefficients), frozen(corner, np.int64), frozen(stop, np.bool_))


def fastest_phases(curve: Curve, velocity: Floats, acceleration: Floats) -> Floats:
    """Return the phases (p, 5) of the time-optimal motion along ``curve``, rest to rest; limits (dof,).

    A phase has constant d²s/dt². Its columns: the piece, s and ds/dt at its start, d²s/dt², and its seconds.
    """
    intervals = np.where(curve.corner < 0, _RAMP, _CORNER)
    return curve_phases(curve.coefficients, curve.stop, intervals, velocity, acceleration)


def duration_of(phases: Floats) -> float:
    """Return the seconds from rest to rest."""
    return float(phases[:, 4].sum())


def knot_spacing(limits: MotionLimits, q: Floats) -> tuple[int, int]:
    """Return two times in ns along q (k, dof): the window of the mean, and the least time between knots."""
    knot_interval = min_knot_interval(limits, q)
    return max(smoothing_window(limits.acceleration, limits.jerk), 4 * knot_interval), knot_interval


def min_knot_interval(
    limits: MotionLimits, q: Floats, kinds: Sequence[str] = KINDS, nearest: int = _NEAREST, share: float = _SHARE
) -> int:
    """Return the least time (ns) between knots, ``nearest`` or more, for positions q (k, dof).

    Rounded positions then use at most a ``share`` of any limit of the first ``kinds``.
    """
    noise = _ROUNDED * np.spacing(np.abs(q).max(axis=0))
    shares = [
        (most * noise / (share * getattr(limits, kind))).max() ** (1 / order)
        for order, (kind, most) in enumerate(zip(kinds, LEAST_JERK, strict=False), 1)
    ]
    return max(nearest, ceil(max(shares) / NANOSECOND))


def smoothing_window(acceleration: Floats, jerk: Floats) -> int:
    """Return the window (ns) of the mean that keeps every joint's jerk within its limit (dof,)."""
    return int(np.ceil(max(float((2.0 * acceleration / jerk).max()), _SHORTEST_WINDOW) / NANOSECOND))


def average_motion(
    curve: Curve, phases: Floats, stretch: float, spacing: tuple[int, int], joints: tuple[str, ...]
) -> tuple[Trajectory, Ints]:
    """Return the moving average of ``phases``, and the curve's piece (k,) under each of its own pieces.

    The phases run ``stretch`` times as slowly. The average starts and ends at rest, a window after the phases. It waits
    for a window at every stop, and takes at least four knot intervals between two stops.
    """
    window, knot_interval = spacing
    clock, q, qd, piece = curve_knots(curve.coefficients, curve.stop, phases, stretch, window, knot_interval)
    times, *columns = motion_mean(clock, q, qd, window, knot_interval)
    at = np.clip(np.searchsorted(clock, times[:-1], side="right") - 1, 0, len(piece) - 2)
    return Trajectory(joints, times, tuple(columns)), piece[at]


Cost = Callable[[Floats, Floats], Floats]  # of straight motions from (k, dof) to (k, dof)


def joint_distance(a: Floats, b: Floats) -> Floats:
    """Return the lengths (k,) from configurations ``a`` (k, dof) to ``b`` (k, dof): the default cost."""
    return np.sqrt(((b - a) ** 2).sum(axis=1))


def curve_cost(pieces: Floats, cost: Cost) -> float:
    """Return the cost of pieces (m, 3, dof) along chords, each scaled by the curve's length over its own."""
    points, walked = curve_chords(pieces, _POINTS, _CHORD)
    start, end = points[:-1], points[1:]
    return float((cost(start, end) * walked / np.maximum(joint_distance(start, end), _LEAST)).sum())


def shorten(
    curve: Curve, prover: EdgeProver, limits: MotionLimits, floor: float, cost: Cost, most: float
) -> tuple[Curve, Floats, int, Floats]:
    """Return the curve with shortcuts, its phases, the number of shortcuts, and the phases without them.

    Shortcuts are proven, and w stays above ``floor`` on them. The ``cost`` of the whole curve stays below ``most``, or,
    if it is above already, does not grow.
    """
    draws = np.random.default_rng(0).random((TRIES, 2))
    shares = np.array([_SHORTEST_SPAN**draw for draw in draws[:, 0].tolist()])
    spent, tried, count = curve_cost(curve.coefficients, cost), 0, 0
    used, positions = (limits.velocity, limits.acceleration), position_bounds(prover.robot)
    phases = before = fastest_phases(curve, *used)
    while True:
        duration = duration_of(phases)
        spans = duration * shares[tried:]
        early = draws[tried:, 1] * (duration - spans)
        moments = np.stack([early, early + spans], axis=1)
        ramp_choice = next_ramp(prover, curve.coefficients, phases, moments, _SHARES, used, positions)
        if ramp_choice is None:
            return curve, phases, count, before
        number, start, end, ramp = ramp_choice
        tried += number + 1
        shorter = splice(curve, start, _straighten_resting_ends(ramp), end)
        costs = curve_cost(shorter.coefficients, cost)
        if costs <= max(most, spent) and (floor <= 0 or prove_floor(prover.robot, ramp, floor).holds.all()):
            curve, spent, count = shorter, costs, count + 1
            phases = fastest_phases(curve, *used)


def _straighten_resting_ends(ramp: Floats) -> Floats:
    """Return the ramp (m, 3, dof) with a line in place of a piece that rests at the ramp's start or end.

    The direction of such a piece is constant (velocities grow in proportion to the accelerations), and a line's
    parameter moves at rest.
    """
    pieces = ramp.copy()
    for k, s in ((0, 0.0), (-1, 1.0)):
        start, slope, bend = ramp[k]
        at, other = np.abs(slope + 2.0 * s * bend).max(), np.abs(slope + 2.0 * (1.0 - s) * bend).max()
        if at <= _STILL * other:
            pieces[k] = np.stack([start, slope + bend, np.zeros_like(bend)])
    return pieces
