"""A path with its corners rounded by parabolas, as polynomial pieces in a parameter of their own."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.polynomials import part

Place = tuple[int, float]
"""A piece of a curve, and s on it."""
_SHORTEST = 1e-6  # rad (m): a segment shorter than this is no motion
_REST = 1e-6  # of a piece: what is left of it is left out


@dataclass(frozen=True, eq=False)
class Curve:
    """Pieces q(s) = c0 + c1 s + c2 s², s in [0, 1], each beginning where and in the direction that the last one ends.

    ``coefficients`` (m, 3, dof). ``corner`` (m,) is the waypoint whose corner a piece rounds, -1 for others. At the end
    of piece i the motion has to stop where ``stop`` (m,) says so: there the direction changes.
    """

    coefficients: Floats
    corner: Ints
    stop: Bools


def without_standstill(path: Floats) -> Floats:
    """The waypoints (k, dof) without those that do not move on from the one before; start and goal stay what they are.

    A path that does not move at all becomes one configuration.
    """
    kept = [0]
    for k in range(1, len(path)):
        if np.abs(path[k] - path[kept[-1]]).max() > _SHORTEST:
            kept.append(k)
    kept[-1] = len(path) - 1 if len(kept) > 1 else 0
    return path[kept]


def straight(path: Floats) -> Floats:
    """The segments of a path (k, dof) as pieces (k - 1, 3, dof)."""
    delta = np.diff(path, axis=0)
    return np.stack([path[:-1], delta, np.zeros_like(delta)], axis=1)


def blends(path: Floats, widths: Floats) -> Floats:
    """Parabolas (k - 2, 3, dof) that round the inner waypoints of a path (k, dof).

    They leave the segment before a waypoint, and join that behind it, at a share ``widths`` (k - 2,) in [0, 1] of its
    half; with Bézier's control points there and at the waypoint they touch both segments.
    """
    before, at, behind = path[:-2], path[1:-1], path[2:]
    start = at + 0.5 * widths[:, None] * (before - at)
    end = at + 0.5 * widths[:, None] * (behind - at)
    return np.stack([start, 2.0 * (at - start), start - 2.0 * at + end], axis=1)


def rounded(path: Floats, widths: Floats) -> Curve:
    """The path (k, dof) with every corner rounded as far as ``widths`` (k - 2,) say; 0 is a stop at the corner."""
    if len(path) == 1:
        return Curve(np.stack([path, 0 * path, 0 * path], axis=1), np.array([-1]), np.array([True]))
    parabolas, pieces, corner, stop = blends(path, widths), [], [], []
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


def spliced(curve: Curve, start: Place, pieces: Floats, end: Place) -> Curve:
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
