"""The curve of a motion, corners rounded, the quickest motion along it, shortcuts in time, and a mean of limited jerk.

**Quickest** (TOPP-RA: Pham and Pham 2018). Along a piece q(s) the joints' acceleration is q' u + q'' x with u = d²s/dt²
and x = (ds/dt)², dx/ds = 2 u. On a grid within the pieces u is constant, so x is linear in s; q' is linear too and q''
constant, so that every joint's acceleration is linear in s: within limits at both ends of an interval it is so
everywhere on it. From the end back the largest x from which the rest can be done, from the start on the largest u that
stays below it. A velocity limit bounds x by the square of v / q', which is not linear: between the ends of an interval
a chord below it is kept to, so that 24 intervals a corner come within 0.4 % of 800. Lines need no grid.

**Mean** (a moving-average filter: Biagiotti and Melchiorri 2008). The mean of a motion over the last ``window`` seconds
keeps its limits on positions, velocities and accelerations, as means do, and its jerk is at most twice the limit on
acceleration by ``window``. It begins and ends at rest where the motion does, ``window`` later. On a line it stays on
the line. At a stop the motion waits for a ``window``, so that the mean reaches the corner itself. The knots are those
of the motion, and ``window`` behind each. The mean's acceleration is continuous, and so is that of the quintics through
its knots: their jerk is all the jerk that there is. On lines they are the mean itself; on parabolas close to it.

Positions are doubles: of what they are rounded by between two knots, h apart, quintics make a jerk of 60 / h³ of it. So
knots keep apart by as much as the limits ask for.

**Shortcuts** (Hauser and Ng-Thow-Hing 2010). Between two states of the motion, position and velocity, every joint takes
its own parabolic ramp, all in the same time. Where that takes less time than the motion did, is proven to keep clear
and above the manipulability floor, and leaves the cost of the whole within what is allowed, it takes the place of what
lies between. Ramps are parabolas, as rounded corners are: the path stays a curve of lines and parabolas, along which
the quickest motion is found anew.
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

Place = tuple[int, float]
"""A piece of a curve, and s on it."""

_CORNER, _RAMP = 24, 3  # intervals of the parabolas of corners and ramps: s of a ramp is time, u stays near 0 there
_ROUNDED = 4  # last bits of a position: the difference of two knots is known no better
_SHARE = 1e-3  # of a limit: what rounding may take
_NEAREST = 50_000  # ns: no knots are nearer than this
_SHORTEST_WINDOW = 1e-3  # s
_SHORTEST = 1e-6  # rad (m): a segment shorter than this is no motion
_REST = 1e-6  # of a piece: what is left of it is left out
TRIES = 60  # with twice as many motions take 2 % less, and timing them 1.6 times as long
_SHARES = np.linspace(0.3, 0.98, 35)  # of the time between two moments: how long a ramp may take
_SHORTEST_SPAN = 0.05  # of the motion: moments nearer than this are not joined
_POINTS = 16  # per piece, between which its length is measured
_CHORD = 0.1  # rad (m): the cost is measured along chords that are about as long, or longer
_LEAST = 1e-12  # rad (m)
_STILL = 1e-9  # of the velocity at a ramp's other end: rest


@dataclass(frozen=True, eq=False)
class Curve:
    """Pieces q(s) = c0 + c1 s + c2 s², s in [0, 1], each beginning where and in the direction that the last one ends.

    ``coefficients`` (m, 3, dof). ``corner`` (m,) is the waypoint whose corner a piece rounds, -1 for others. At the end
    of piece i the motion has to stop where ``stop`` (m,) says so: there the direction changes.
    """

    coefficients: Floats
    corner: Ints
    stop: Bools


def drop_standstills(path: Floats) -> Floats:
    """The waypoints (k, dof) without those that do not move on from the one before; start and goal stay what they are.

    A path that does not move at all becomes one configuration.
    """
    kept = [0]
    for k in range(1, len(path)):
        if np.abs(path[k] - path[kept[-1]]).max() > _SHORTEST:
            kept.append(k)
    kept[-1] = len(path) - 1 if len(kept) > 1 else 0
    return path[kept]


def path_segments(path: Floats) -> Floats:
    """The segments of a path (k, dof) as pieces (k - 1, 3, dof)."""
    delta = np.diff(path, axis=0)
    return np.stack([path[:-1], delta, np.zeros_like(delta)], axis=1)


def corner_parabolas(path: Floats, widths: Floats) -> Floats:
    """Parabolas (k - 2, 3, dof) that round the inner waypoints of a path (k, dof).

    They leave the segment before a waypoint, and join that behind it, at a share ``widths`` (k - 2,) in [0, 1] of its
    half; with Bézier's control points there and at the waypoint they touch both segments.
    """
    before, at, behind = path[:-2], path[1:-1], path[2:]
    start = at + 0.5 * widths[:, None] * (before - at)
    end = at + 0.5 * widths[:, None] * (behind - at)
    return np.stack([start, 2.0 * (at - start), start - 2.0 * at + end], axis=1)


def round_corners(path: Floats, widths: Floats) -> Curve:
    """The path (k, dof) with every corner rounded as far as ``widths`` (k - 2,) say; 0 is a stop at the corner."""
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


def splice(curve: Curve, start: Place, pieces: Floats, end: Place) -> Curve:
    """The curve with ``pieces`` (m, 3, dof) in place of what lies between two places.

    They have to begin and end there in the curve's directions, or at rest.
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
    made = np.concatenate([before, pieces, after])
    corner = np.concatenate([curve.corner[head], np.full(len(pieces), -1), curve.corner[tail]])
    stop = np.concatenate([stop_before, np.zeros(len(pieces), dtype=bool), stop_after])
    if high >= 1.0 - _REST:
        stop[len(before) + len(pieces) - 1] = curve.stop[last]
    return Curve(frozen(made), frozen(corner, np.int64), frozen(stop, np.bool_))


def fastest_phases(curve: Curve, velocity: Floats, acceleration: Floats) -> Floats:
    """The phases (p, 5) of the quickest motion along ``curve`` from rest to rest; limits (dof,).

    Each is of constant acceleration of a piece's parameter: the piece, s and ds/dt where it begins, d²s/dt², seconds.
    """
    intervals = np.where(curve.corner < 0, _RAMP, _CORNER)
    return curve_phases(curve.coefficients, curve.stop, intervals, velocity, acceleration)


def duration_of(phases: Floats) -> float:
    """Seconds from rest to rest."""
    return float(phases[:, 4].sum())


def knot_spacing(limits: MotionLimits, q: Floats) -> tuple[int, int]:
    """Nanoseconds: the window that the mean is taken over, and how far knots are apart at least, along q (k, dof)."""
    apart = min_knot_interval(limits, q)
    return max(smoothing_window(limits.acceleration, limits.jerk), 4 * apart), apart


def min_knot_interval(
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


def smoothing_window(acceleration: Floats, jerk: Floats) -> int:
    """Nanoseconds to take the mean over so that no jerk is beyond its limit (dof,)."""
    return int(np.ceil(max(float((2.0 * acceleration / jerk).max()), _SHORTEST_WINDOW) / NANOSECOND))


def average_motion(
    curve: Curve, phases: Floats, stretch: float, spacing: tuple[int, int], joints: tuple[str, ...]
) -> tuple[Trajectory, Ints]:
    """The mean over the last window of ``phases``, ``stretch`` times as slow, from rest to a window after their end.

    At every stop on the way it waits for a window; between two it takes four times as long as knots are apart, or
    longer. Second the curve's piece (k,) that each piece of the trajectory runs on.
    """
    window, apart = spacing
    clock, q, qd, piece = curve_knots(curve.coefficients, curve.stop, phases, stretch, window, apart)
    times, *columns = motion_mean(clock, q, qd, window, apart)
    at = np.clip(np.searchsorted(clock, times[:-1], side="right") - 1, 0, len(piece) - 2)
    return Trajectory(joints, times, tuple(columns)), piece[at]


Cost = Callable[[Floats, Floats], Floats]


def joint_distance(a: Floats, b: Floats) -> Floats:
    """(k,) lengths from configurations ``a`` (k, dof) to ``b`` (k, dof): the cost where no other is given."""
    return np.sqrt(((b - a) ** 2).sum(axis=1))


def curve_cost(pieces: Floats, cost: Cost) -> float:
    """What pieces (m, 3, dof) cost: along chords, each as much more as the curve is longer there."""
    points, walked = curve_chords(pieces, _POINTS, _CHORD)
    start, end = points[:-1], points[1:]
    return float((cost(start, end) * walked / np.maximum(joint_distance(start, end), _LEAST)).sum())


def shorten(
    curve: Curve, prover: EdgeProver, limits: MotionLimits, floor: float, cost: Cost, most: float
) -> tuple[Curve, Floats, int, Floats]:
    """The curve with proven shortcuts, the quickest phases along it, how many, and the quickest phases before.

    On shortcuts w stays above the ``floor``.
    ``cost`` gives that of straight motions from (k, dof) to (k, dof); for the whole curve it stays below ``most``, or
    where it is beyond already below what it is.
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
        found = next_ramp(prover, curve.coefficients, phases, moments, _SHARES, used, positions)
        if found is None:
            return curve, phases, count, before
        number, start, end, ramp = found
        tried += number + 1
        shorter = splice(curve, start, _without_rest(ramp), end)
        costs = curve_cost(shorter.coefficients, cost)
        if costs <= max(most, spent) and (floor <= 0 or prove_floor(prover.robot, ramp, floor).holds.all()):
            curve, spent, count = shorter, costs, count + 1
            phases = fastest_phases(curve, *used)


def _without_rest(ramp: Floats) -> Floats:
    """The ramp (m, 3, dof) with lines, whose parameter moves there, where it begins or ends at rest.

    There its direction does not change: velocities grow in proportion to the accelerations.
    """
    made = ramp.copy()
    for k, s in ((0, 0.0), (-1, 1.0)):
        start, slope, bend = ramp[k]
        at, other = np.abs(slope + 2.0 * s * bend).max(), np.abs(slope + 2.0 * (1.0 - s) * bend).max()
        if at <= _STILL * other:
            made[k] = np.stack([start, slope + bend, np.zeros_like(bend)])
    return made
