"""Distances of triangle meshes, proven: by planes between the hulls of their parts, down to single triangles."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from planner.base.arrays import Floats, Ints
from planner.base.products import dot, product
from planner.collision.separating_plane import Core, core_of, core_of_points, proven_gap
from planner.world.shapes import Mesh, Shape, farthest

_FANOUT = 8  # parts that a part is cut into
_MANY = 40  # points: of more only the corners of their hull are kept
_CONVEX, _DENT = 0.99, 1e-5  # a mesh that fills so much of its hull and is nowhere deeper below it (m) is convex
_NEAR = 2e-4  # m: so near the hull of a mesh that is not convex its triangles are asked instead
_CLOSE = 1e-6  # m: a bound this near the distance is good enough


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape to be measured, made once: the convex hull of all of it, and its triangles where it is a mesh.

    ``depth`` (m): where the hull is no farther away than this it does not stand for the shape; 0 for a convex shape.
    """

    shape: Shape
    whole: _Part
    depth: float

    @staticmethod
    def of(shape: Shape) -> Solid:
        if not isinstance(shape, Mesh):
            return Solid(shape, _Part(np.zeros((1, 3)), np.empty((0, 3, 3)), farthest(shape, np.eye(4))), 0.0)
        triangles = shape.vertices[shape.triangles]
        return Solid(shape, _part(triangles), 0.0 if _is_convex(triangles) else _NEAR)

    def hull_faces(self) -> tuple[Floats, Ints] | None:
        """Corners (k, 3) and triangles (m, 3) of a mesh's convex hull; None for primitives and flat meshes."""
        if not self.is_mesh:
            return None
        try:
            return self.whole.points, ConvexHull(self.whole.points).simplices.astype(np.int64)
        except QhullError:
            return None

    @property
    def is_mesh(self) -> bool:
        return isinstance(self.shape, Mesh)


class _Part:
    """Some triangles (n, 3, 3) of a mesh, the corners (k, 3) of their hull, and a ball that holds them."""

    def __init__(self, points: Floats, triangles: Floats, size: float | None = None) -> None:
        self.points, self._triangles = points, triangles
        self.middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        self.size = float(np.linalg.norm(points - self.middle, axis=1).max()) if size is None else size
        self.is_last = len(triangles) < 2

    @cached_property
    def parts(self) -> _Parts:
        """The smaller parts, cut when they are first asked for: a large mesh is never cut up everywhere."""
        groups = [self._triangles]
        while len(groups) < _FANOUT and len(groups[-1]) > 1:
            groups += _halves(groups.pop())
            groups.sort(key=len)
        return _Parts.of([_part(group) for group in groups])


def _part(triangles: Floats) -> _Part:
    return _Part(_outermost(triangles.reshape(-1, 3)), triangles)


@dataclass(frozen=True, eq=False)
class _Parts:
    """What a part is cut into, and the arrays over all of it."""

    parts: list[_Part]
    points: Floats  # (k, 3), part after part
    first: Ints  # where each part's points begin
    middles: Floats
    sizes: Floats

    @staticmethod
    def of(parts: list[_Part]) -> _Parts:
        counts = [len(part.points) for part in parts]
        return _Parts(
            parts,
            np.concatenate([part.points for part in parts]),
            np.cumsum([0, *counts[:-1]]),
            np.array([part.middle for part in parts]),
            np.array([part.size for part in parts]),
        )


def _halves(triangles: Floats) -> list[Floats]:
    """Cut at the median of the middles along the axis on which they are spread most."""
    middles = triangles.mean(axis=1)
    order = np.argsort(middles[:, int(np.ptp(middles, axis=0).argmax())], kind="stable")
    return [triangles[order[: len(order) // 2]], triangles[order[len(order) // 2 :]]]


def _outermost(points: Floats) -> Floats:
    """Fewer points with the same hull, where there are many."""
    if len(points) < _MANY:
        return points
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:  # they lie in a plane
        return np.unique(points, axis=0)


def _is_convex(triangles: Floats) -> bool:
    """Whether a closed mesh is its own convex hull, to ten micrometres at its corners and middles of sides.

    A hull taken for its mesh by mistake is still a bound: some segments would be left unproven, no more.
    """
    try:
        hull = ConvexHull(triangles.reshape(-1, 3))
    except QhullError:
        return False
    a, b, c = (triangles[:, k] - triangles[0, 0] for k in range(3))
    volume = abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6.0
    if volume < _CONVEX * hull.volume:
        return False
    points = np.concatenate([triangles, 0.5 * (triangles + np.roll(triangles, 1, axis=1))]).reshape(-1, 3)
    above = points @ hull.equations[:, :3].T + hull.equations[:, 3]
    return float(above.max(axis=1).min()) > -_DENT


class PlacedSolid:
    """A solid somewhere: rotation (3, 3) and position (3,)."""

    def __init__(self, solid: Solid, turn: Floats, position: Floats) -> None:
        self.solid, self.turn, self.position = solid, turn, position

    @cached_property
    def hull(self) -> _PlacedPart:
        part = self.solid.whole
        points = part.points @ self.turn.T + self.position
        core = core_of_points(points) if self.solid.is_mesh else core_of((self.solid.shape, self.turn, self.position))
        return _PlacedPart(self, part, core, part.middle @ self.turn.T + self.position)


class _PlacedPart:
    def __init__(self, owner: PlacedSolid, part: _Part, core: Core, middle: Floats) -> None:
        self.owner, self.part, self.core, self.middle = owner, part, core, middle

    def reach(self, direction: Floats) -> float:
        """How far (m) along a unit vector the part extends."""
        return dot(self.core.farthest(direction), direction) + self.core.radius

    def cut(self, other: _PlacedPart, towards: Floats) -> Iterable[tuple[float, _PlacedPart]]:
        """The smaller parts, each with a lower bound on its distance from ``other``, which lies ``towards`` there.

        By the plane across that direction that touches the other, and by the balls around both.
        """
        cut, turn, shift = self.part.parts, self.owner.turn, self.owner.position
        points, middles = cut.points @ turn.T + shift, cut.middles @ turn.T + shift
        beyond = -other.reach(-towards) - np.maximum.reduceat(product(points, towards), cut.first)
        apart = np.linalg.norm(middles - other.middle, axis=1) - cut.sizes - other.part.size
        for k, group in enumerate(np.split(points, cut.first[1:])):
            placed = _PlacedPart(self.owner, cut.parts[k], core_of_points(group), middles[k])
            yield max(float(beyond[k]), float(apart[k])), placed


def hull_gap(first: PlacedSolid, second: PlacedSolid, apart: Floats, high: float, share: float = 0.0) -> float:
    """A lower bound (m) on the distance of two solids: that of their hulls, less ``share`` of it or a micrometre.

    ``apart`` (3,) and ``high`` (m): a guess of the vector between the hulls and of its length.
    """
    return proven_gap(first.hull.core, second.hull.core, apart, share, high).low


def surface_gap(first: PlacedSolid, second: PlacedSolid, share: float = 0.0) -> float:
    """A lower bound (m) on the distance of two solids, a mesh being the surface of its triangles; 0 where they touch.

    The pair of parts with the smallest bound is measured, then cut, until it is a pair of triangles or primitives that
    no other pair undercuts by more than ``share`` of the distance or a micrometre (best first; Land and Doig 1960).
    """
    latest, nearest = itertools.count(0, -1), np.inf  # of equal bounds the part cut last comes first
    towards = second.hull.middle - first.hull.middle
    heap: list[tuple[float, int, bool, Floats, _PlacedPart, _PlacedPart]] = []
    heap.append((0.0, next(latest), False, towards, first.hull, second.hull))
    while True:
        bound, _, measured, towards, a, b = heapq.heappop(heap)
        if nearest - bound <= max(_CLOSE, share * bound) or (measured and a.part.is_last and b.part.is_last):
            return bound
        if not measured:
            gap = proven_gap(a.core, b.core, towards, share)
            if a.part.is_last and b.part.is_last:
                nearest = min(nearest, gap.high)
            heapq.heappush(heap, (max(bound, gap.low), next(latest), True, gap.normal, a, b))
        elif b.part.is_last or (not a.part.is_last and a.part.size >= b.part.size):
            for low, part in a.cut(b, towards):
                heapq.heappush(heap, (max(bound, low), next(latest), False, towards, part, b))
        else:
            for low, part in b.cut(a, -towards):
                heapq.heappush(heap, (max(bound, low), next(latest), False, towards, a, part))
