"""How far apart two convex shapes are for certain: any plane between them is a proof, however it was found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from planner.base.arrays import Floats
from planner.base.products import dot, length, product
from planner.world.shapes import Cylinder, Shape, corners

Placed: TypeAlias = tuple[Shape, Floats, Floats]  # shape, rotation (3, 3), position (3,)
Farthest: TypeAlias = Callable[[Floats], Floats]  # direction (3,) -> the point (3,) farthest along it

_ROUNDS = 40
_CLOSE = 1e-6  # m: a bound this near the distance is good enough
_TOUCHING = 1e-12  # m
_THIN = 1e-20  # squared sine below which three corners are taken to lie in a line


@dataclass(frozen=True)
class Core:
    """A placed convex set by its farthest points; what it stands for reaches ``radius`` (m) beyond it."""

    farthest: Farthest
    radius: float = 0.0

    def extreme(self, direction: Floats) -> Floats:
        """The point (3,) farthest along a unit vector of all that is no farther than ``radius`` from the set."""
        return self.farthest(direction) + self.radius * direction


def core_of(placed: Placed) -> Core:
    """A primitive as the convex set inside it and the radius about that; a mesh counts as its convex hull."""
    shape, turn, position = placed
    if isinstance(shape, Cylinder):
        return Core(_farthest_of_cylinder(shape, turn, position))
    points, radius = corners(shape)
    return core_of_points(points @ turn.T + position, radius)


def core_of_points(points: Floats, radius: float = 0.0) -> Core:
    """The convex hull of ``points`` (k, 3)."""
    return Core(lambda direction: points[product(points, direction).argmax()], radius)


def _farthest_of_cylinder(shape: Cylinder, turn: Floats, position: Floats) -> Farthest:
    half, plane = 0.5 * shape.length * turn[:, 2], np.ascontiguousarray(turn[:, :2])

    def farthest(direction: Floats) -> Floats:
        end = position + half if dot(direction, half) > 0.0 else position - half
        across = product(direction, plane)
        norm = length(across)
        return end + product(plane, shape.radius / norm * across) if norm > 0.0 else end

    return farthest


@dataclass(frozen=True)
class Gap:
    """The distance (m) of two sets is at least ``low``, as the planes across ``normal`` (3,) prove that touch them.

    Two points prove that it is at most ``high``. Both are 0 where the sets touch.
    """

    low: float
    high: float
    normal: Floats


def proven_gap(first: Core, second: Core, apart: Floats, share: float = 0.0, high: float = np.inf) -> Gap:
    """Bounds on the distance of two convex sets, ``share`` of it or a micrometre apart.

    ``apart`` (3,) is a first guess of the vector from the first to the second, or back, ``high`` of its length. One
    round proves a good guess. Otherwise the point nearest the origin in a simplex of differences of the sets' points
    gives the next pair of planes, and the points that touch these its next corner (Gilbert, Johnson and Keerthi 1988).
    """
    radius = first.radius + second.radius
    low, high, normal = 0.0, high + radius, np.zeros(3)
    corners: list[Floats] = []
    weights: list[float] = []
    for turn in range(_ROUNDS):
        corner = second.farthest(-apart) - first.farthest(apart)
        if turn == 0 and dot(corner, apart) < 0.0:
            apart = -apart
            continue
        size = length(apart)
        between = dot(corner, apart) / size if size > 0.0 else 0.0
        if between > low:
            low, normal = between, apart / size
        if high - low <= max(_CLOSE, share * (low - radius)) or any(np.array_equal(c, corner) for c in corners):
            break
        corners, weights = _towards_origin([*corners, corner], [*weights, 0.0 if corners else 1.0])
        apart = sum((w * c for w, c in zip(weights, corners, strict=True)), np.zeros(3))
        high = min(high, length(apart))
        if high <= radius + _TOUCHING:
            return Gap(0.0, 0.0, normal)
    return Gap(max(0.0, low - radius), max(0.0, high - radius), normal)


def _towards_origin(corners: list[Floats], weights: list[float]) -> tuple[list[Floats], list[float]]:
    """From the point of these weights to the one nearest the origin in the hull of up to four ``corners`` (3,).

    Those corners that the nearest point rests on, and its weights. Wolfe (1976): to the nearest point in the flat
    through the corners, or as far as the hull goes; then without the corner that is left behind there.
    """
    while len(corners) > 1:
        best = _nearest_in_flat(corners)
        if min(best) > 0.0:
            return corners, best
        pairs = list(zip(weights, best, strict=True))
        shares = [1.0 if b > 0.0 else w / (w - b) if w > 0.0 else 0.0 for w, b in pairs]
        share, k = min((share, j) for j, (share, (_, b)) in enumerate(zip(shares, pairs, strict=True)) if b <= 0.0)
        weights = [w + share * (b - w) for j, (w, b) in enumerate(pairs) if j != k]
        corners = corners[:k] + corners[k + 1 :]
        total = sum(weights)
        weights = [max(0.0, w) / total for w in weights]
    return corners, [1.0]


def _nearest_in_flat(corners: list[Floats]) -> list[float]:
    """Weights, summing to 1, of the point nearest the origin in the flat through two to four ``corners``.

    By Gram and Schmidt; a corner that opens no new direction gets no weight.
    """
    first, *others = corners
    sides = [corner - first for corner in others]
    rows: list[tuple[int, Floats, float, list[float]]] = []  # side, its new direction, that squared, shares of the old
    for k, side in enumerate(sides):
        shares = [dot(old, side) / square for _, old, square, _ in rows]
        new = side - sum((share * old for share, (_, old, _, _) in zip(shares, rows, strict=True)), np.zeros(3))
        square = dot(new, new)
        if square > _THIN * dot(side, side):
            rows.append((k, new, square, shares))
    along = [-dot(first, new) / square for _, new, square, _ in rows]
    weights = [0.0] * len(sides)
    for j in reversed(range(len(rows))):
        weights[rows[j][0]] = along[j]
        for i, share in enumerate(rows[j][3]):
            along[i] -= share * along[j]
    return [1.0 - sum(weights), *weights]
