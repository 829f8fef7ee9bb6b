"""A path with its corners rounded by parabolas, as polynomial pieces in a parameter of their own."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen

_SHORTEST = 1e-6  # rad (m): a segment shorter than this is no motion


@dataclass(frozen=True, eq=False)
class Curve:
    """Pieces q(s) = c0 + c1 s + c2 s², s in [0, 1], each beginning where and in the direction that the last one ends.

    ``coefficients`` (m, 3, dof). ``corner`` (m,) is the waypoint whose corner a piece rounds, -1 for a line. At the end
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
