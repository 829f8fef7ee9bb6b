"""The convex hulls of meshes, and how far the meshes lie below them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from planner.base.arrays import Floats, Ints, distinct_rows
from planner.base.kept import kept
from planner.base.products import product
from planner.models.shapes import Mesh
from planner.models.solids import solid_of

_MANY = 200  # points: of more only the corners of their hull are kept
_MOST = 4_000_000  # distances of corners from planes: larger meshes are taken to have dents


def hull_corners(points: Floats) -> Floats:
    """Of ``points`` (n, 3) fewer (k, 3) with the same convex hull, where there are many."""
    points = points[distinct_rows(points)[0]]
    if len(points) < _MANY:
        return points
    return points[kept("hulls", [points], lambda: {"rows": _hull(points)})["rows"]]


def _hull(points: Floats) -> Ints:
    """The rows of ``points`` (n, 3) that are corners of their hull; all of them where they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError  # 0.3 s to load

    try:
        return ConvexHull(points).vertices.astype(np.int64)
    except QhullError:
        return np.arange(len(points))


@lru_cache(maxsize=1024)
def dent(mesh: Mesh) -> float:
    """How deep (m) the surface of a mesh lies below its convex hull at most, roughly; inf where it is not closed.

    0 where it is convex: how far any corner rises above any triangle. It says where the hull is good enough a bound.
    """
    if len(mesh.triangles) < _MANY:
        return _dent(mesh)
    return float(kept("dents", mesh.content(), lambda: {"depth": np.array(_dent(mesh))})["depth"])


def _dent(mesh: Mesh) -> float:
    solid = solid_of(mesh)
    if solid is None or len(solid.corners) < len(mesh.triangles):
        return np.inf
    corners, points = solid.corners, mesh.vertices[mesh.triangles].reshape(-1, 3)
    points = points[distinct_rows(points)[0]]
    if len(corners) * len(points) > _MOST:
        return np.inf
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    offset = np.einsum("ij,ij->i", normal, corners[:, 0])
    outwards = np.where(product(normal, points.mean(axis=0)) > offset, -1.0, 1.0)
    above = (product(points, np.ascontiguousarray(normal.T)) - offset) * outwards
    return max(0.0, float(above.max()))
