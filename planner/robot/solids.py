"""Closed meshes as solids: enclosed volumes, and tests of points by winding numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from planner.base.arrays import Bools, Floats, Ints, column_bounds, distinct_rows, frozen
from planner.robot.clouds import Points, Seen, Voxels
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

_CHUNK = 200_000  # solid angles at a time


@dataclass(frozen=True, eq=False)
class Solid:
    """The closed components of a mesh: ``corners`` (m, 3, 3) of triangles, ``low`` and ``high`` (3,), m."""

    corners: Floats
    low: Floats
    high: Floats

    def contains(self, points: Floats) -> Bools:
        """Return which points (k, 3) lie inside, by winding numbers.

        A hollow body of two surfaces that face away from the material is hollow. A single surface may face in or out.
        Points on the surface may be either.
        """
        inside: Bools = np.all((points > self.low) & (points < self.high), axis=1)
        rows = np.flatnonzero(inside)
        step = max(1, _CHUNK // len(self.corners))
        for k in range(0, len(rows), step):
            part = rows[k : k + step]
            inside[part] = np.abs(_winding(self.corners, points[part])) > 0.5
        return inside


@dataclass(frozen=True, eq=False)
class CellSolid(Solid):
    """The solid cells of ``voxels``, found in their grid, as libraries know only the faces of the cuboids."""

    voxels: Voxels

    def contains(self, points: Floats) -> Bools:
        """Return which points (k, 3) lie in a solid cell."""
        inside: Bools = np.all((points > self.low) & (points < self.high), axis=1)
        cells = ((points[inside] - self.voxels.origin) / self.voxels.pitch).astype(np.int64)
        cells = np.minimum(cells, np.array(self.voxels.occupied.shape) - 1)  # a point may round onto the far side
        inside[inside] = self.voxels.occupied[tuple(cells.T)]
        return inside


def _winding(corners: Floats, points: Floats) -> Floats:
    """Return winding numbers of triangles (m, 3, 3) around points (k, 3) (Van Oosterom, Strackee 1983)."""
    a, b, c = (corners[None, :, k] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    volume = np.einsum("kmi,kmi->km", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("kmi,kmi->km", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum(axis=1) / (2 * np.pi)


@lru_cache(maxsize=1024)
def solid_of(mesh: Mesh) -> Solid | None:
    """Return the closed components of ``mesh`` as a solid, or None without any."""
    if isinstance(mesh, Voxels):
        low, high = column_bounds(mesh.vertices)
        return CellSolid(mesh.vertices[mesh.triangles], frozen(low), frozen(high), mesh)
    if isinstance(mesh, Points):
        return None
    triangles, component, closed = _components(mesh)
    if not closed.any():
        return None
    corners = mesh.vertices[triangles[closed[component]]]
    points = corners.reshape(-1, 3)
    return Solid(frozen(corners), frozen(points.min(axis=0)), frozen(points.max(axis=0)))


def is_watertight(mesh: Mesh) -> bool:
    """Return whether every component of ``mesh`` is closed and consistently oriented."""
    closed = _components(mesh)[2]
    return len(closed) > 0 and bool(closed.all())


def is_closed(triangles: Ints) -> bool:
    """Return whether the triangles (m, 3) pass every edge equally often in both directions.

    Winding numbers are then integers, also for edges of more than two triangles.
    """
    a, b = triangles[:, [0, 1, 2]].ravel(), triangles[:, [1, 2, 0]].ravel()
    _, edge = distinct_rows(np.column_stack([np.minimum(a, b), np.maximum(a, b)]))
    return not np.bincount(edge, weights=np.where(a < b, 1.0, -1.0)).any()


@lru_cache(maxsize=1024)
def points_of_components(shape: Shape) -> Floats:
    """Return a point (k, 3) of each connected component of a shape, in its own frame.

    If all of them are outside another body, and no surfaces cross, the whole shape is outside.
    """
    if not isinstance(shape, Mesh):
        return np.zeros((1, 3))
    if isinstance(shape, Seen):
        return shape.representatives
    triangles, component, _ = _components(shape)
    return frozen(shape.vertices[triangles[np.unique(component, return_index=True)[1], 0]])


def could_contain(solid: Solid, measures: Floats) -> Bools:
    """Return which ``measures`` (k, 2) of shapes fit into the solid's bounding box; never wrongly False."""
    size = np.asarray(solid.high - solid.low)
    fits: Bools = np.all(measures <= [np.linalg.norm(size), size.min()], axis=1)
    return fits


def shape_measures(shapes: Sequence[Shape]) -> Floats:
    """Return (k, 2) m: a distance of two points of each shape, and the diameter of a ball inside."""
    return np.array([_measures(shape) for shape in shapes]).reshape(-1, 2)


@lru_cache(maxsize=1024)
def _measures(shape: Shape) -> tuple[float, float]:
    """Return a distance of two points of the shape and the diameter of a ball inside it, m."""
    match shape:
        case Box(size):
            return float(np.linalg.norm(size)), min(size)
        case Sphere(radius):
            return 2 * radius, 2 * radius
        case Cylinder(radius, length):
            return float(np.hypot(length, 2 * radius)), min(length, 2 * radius)
        case Capsule(radius, length):
            return length + 2 * radius, 2 * radius
        case Seen():
            return 0.0, 0.0  # any cell may be inside
        case Mesh():
            points = shape.vertices[vertices_in_triangles(shape)]
            pieces = len(points_of_components(shape))
            return (float(np.ptp(points, axis=0).max()) if pieces == 1 else 0.0), 0.0  # any one piece may be inside


def vertices_in_triangles(mesh: Mesh) -> Ints:
    """Return indices of the vertices that triangles use."""
    return np.flatnonzero(np.bincount(mesh.triangles.ravel()))


def component_of_vertices(mesh: Mesh) -> Ints:
    """Return the component (n,) of each vertex; -1 without a triangle of nonzero area."""
    triangles, component, _ = _components(mesh)
    first, same = distinct_rows(mesh.vertices)
    inside = np.full(len(mesh.vertices), -1, dtype=np.int64)
    inside[triangles] = component[:, None]
    return inside[first[same]]


@lru_cache(maxsize=1024)
def _components(mesh: Mesh) -> tuple[Ints, Ints, Bools]:
    """Return triangles (m, 3) of nonzero area, their component (m,), and which components are closed."""
    first, same = distinct_rows(mesh.vertices)
    triangles = first[same][mesh.triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    a, b, c = triangles.T
    edges = np.concatenate([a, a]), np.concatenate([b, c])
    graph = coo_array((np.ones(len(edges[0])), edges), shape=(len(same), len(same)))
    component = np.unique(connected_components(graph, directed=False)[1][a], return_inverse=True)[1].astype(np.int64)
    closed = [is_closed(triangles[component == k]) for k in range(int(component.max(initial=-1)) + 1)]
    return triangles, component, np.array(closed, dtype=bool)
