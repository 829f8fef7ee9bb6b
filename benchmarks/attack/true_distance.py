"""The distance of two shapes, slow but certified: the reference for what the collision libraries claim.

Shares nothing with them. A shape is one convex core or many (a mesh: its triangles), each with a radius about it. The
two nearest points of two cores are found by Wolfe's algorithm for the point of least norm in their Minkowski
difference; the points prove that the distance is no larger, the plane between them that it is no smaller. A cloud is
its balls, voxels are a cube for each solid cell.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from planner.base.arrays import Floats
from planner.robot.clouds import Points, Voxels
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.robot.solids import is_watertight

PRECISION = 1e-12  # m: between the two bounds, where placements are a few metres from the origin
_ROUNDS = 200

Placed: TypeAlias = tuple[Shape, Floats]  # a shape and its placement (4, 4) in the world
_Support: TypeAlias = Callable[[Floats], Floats]  # direction (3,) -> the farthest point (3,) of a core


@dataclass(frozen=True)
class Gap:
    """The true distance (m) lies between ``low``, which a plane proves, and ``high``, which two points prove.

    Both are 0 where the shapes touch; ``low`` is 0 where no plane was found between them.
    """

    low: float
    high: float


@dataclass(frozen=True, eq=False)
class _Core:
    """A convex set in the ball ``centre`` (3,), ``size`` (m), and the radius about it that belongs to the shape."""

    support: _Support
    centre: Floats
    size: float
    radius: float


def true_distance(first: Placed, second: Placed) -> Gap:
    """How far apart two placed shapes are; a mesh is the surface of its triangles, all others are solid."""
    return nearest([first], [second])


def nearest(first: list[Placed], second: list[Placed]) -> Gap:
    """The distance of the nearest two of two groups of placed shapes."""
    a, b = ([core for placed in group for core in _cores(*placed)] for group in (first, second))
    spheres = [(np.array([c.centre for c in g]), np.array([c.size + c.radius for c in g])) for g in (a, b)]
    (ca, ra), (cb, rb) = spheres
    apart = np.linalg.norm(ca[:, None] - cb[None], axis=2) - ra[:, None] - rb[None]
    low = high = np.inf
    for k in np.argsort(apart, axis=None, kind="stable").tolist():
        i, j = divmod(k, len(b))
        if apart[i, j] >= high or high <= 0.0:
            break
        gap = _distance(a[i], b[j])
        low, high = min(low, gap.low), min(high, gap.high)
    return Gap(low, high)


def is_inside(mesh: Placed, points: Floats) -> bool:
    """Whether a watertight mesh holds one of ``points`` (n, 3): an odd number of triangles is above it."""
    shape, placement = mesh
    if not isinstance(shape, Mesh) or not is_watertight(shape):
        return False
    skew = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]  # no edge lies along it
    a, b, c = (shape.vertices @ skew)[shape.triangles].transpose(1, 0, 2)
    at = (points - placement[:3, 3]) @ placement[:3, :3] @ skew
    sides = np.stack([b - a, c - a, np.broadcast_to([0.0, 0.0, 1.0], a.shape)], axis=2)
    upright = np.abs(np.linalg.det(sides)) > 0.0
    share = np.linalg.solve(sides[upright], (at[:, None] - a[upright])[..., None])[..., 0]  # (n, m, 3)
    above = (share[..., :2] >= 0.0).all(axis=2) & (share[..., :2].sum(axis=2) <= 1.0) & (share[..., 2] < 0.0)
    return bool((above.sum(axis=1) % 2 == 1).any())


def _cores(shape: Shape, placement: Floats) -> list[_Core]:
    turn, shift = placement[:3, :3], placement[:3, 3]
    match shape:
        case Sphere(radius):
            return [_hull_of(shift[None], radius)]
        case Capsule(radius, length):
            ends = np.array([[0.0, 0.0, -0.5 * length], [0.0, 0.0, 0.5 * length]])
            return [_hull_of(ends @ turn.T + shift, radius)]
        case Box(size):
            signs = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
            return [_hull_of((signs * np.array(size)) @ turn.T + shift)]
        case Points(vertices=centres, radius=radius):
            return [_hull_of(centre[None], radius) for centre in centres @ turn.T + shift]
        case Voxels(occupied=occupied, pitch=pitch, origin=origin):
            low = origin + pitch * np.argwhere(occupied)
            cubes = low[:, None] + pitch * np.indices((2, 2, 2)).reshape(3, 8).T
            return [_hull_of(corners) for corners in cubes @ turn.T + shift]
        case Mesh(vertices, triangles):
            return [_hull_of(corners) for corners in (vertices @ turn.T + shift)[triangles]]
        case Cylinder(radius, length):
            return [_Core(_cylinder(radius, length, turn, shift), shift, float(np.hypot(radius, 0.5 * length)), 0.0)]


def _hull_of(points: Floats, radius: float = 0.0) -> _Core:
    centre = points.mean(axis=0)
    size = float(np.linalg.norm(points - centre, axis=1).max())
    return _Core(lambda direction: points[(points @ direction).argmax()], centre, size, radius)


def _cylinder(radius: float, length: float, turn: Floats, shift: Floats) -> _Support:
    half = 0.5 * length * turn[:, 2]

    def farthest(direction: Floats) -> Floats:
        across = direction @ turn[:, :2]
        norm = float(np.hypot(*across))
        rim = turn[:, :2] @ (radius / norm * across) if norm > 0.0 else 0.0
        return shift + np.copysign(1.0, direction @ half) * half + rim

    return farthest


def _distance(a: _Core, b: _Core) -> Gap:
    """Wolfe (1976): a simplex in a - b moves towards the origin until a plane says that nothing is nearer."""
    radius = a.radius + b.radius
    nearest = a.centre - b.centre
    corners = np.array([a.support(-nearest) - b.support(nearest)])
    weights = np.ones(1)
    low, high = 0.0, np.inf
    for _ in range(_ROUNDS):
        point = weights @ corners
        norm = float(np.sqrt(point @ point))
        if norm < high:
            high, nearest = norm, point
        if high <= PRECISION or high <= radius:
            return Gap(0.0, 0.0)
        corner = a.support(-point) - b.support(point)
        low = max(low, float(corner @ point) / norm)
        if high - low <= 0.01 * PRECISION or (corners == corner).all(axis=1).any():
            break
        corners, weights = _minimise(np.vstack([corners, corner]), np.append(weights, 0.0))
    return Gap(max(0.0, low - radius), max(0.0, high - radius))


def _minimise(corners: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """The corners of the face that holds the point nearest the origin, and the point's weights there."""
    while True:
        affine = _affine_minimum(corners)
        if (affine > 0.0).all():
            return corners, affine
        down = affine < weights
        falling = down & (affine <= 0.0)
        shares = weights[falling] / (weights[falling] - affine[falling])
        share = float(shares.min(initial=1.0))
        weights = (1.0 - share) * weights + share * affine
        weights[np.flatnonzero(falling)[int(shares.argmin())] if len(shares) else int(affine.argmin())] = 0.0
        kept = weights > 0.0
        corners, weights = corners[kept], weights[kept] / weights[kept].sum()
        if len(weights) == 1:
            return corners, weights


def _affine_minimum(corners: Floats) -> Floats:
    """Weights, summing to 1, of the point nearest the origin in the flat through the corners."""
    sides = corners[1:] - corners[0]
    rest = np.linalg.lstsq(sides.T, -corners[0], rcond=None)[0]
    return np.append(1.0 - rest.sum(), rest)
