"""The convex hulls of meshes, and how far the meshes lie below them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from planner.base.arrays import Floats, distinct_rows, frozen, product
from planner.robot.shapes import Mesh
from planner.robot.solids import points_used, solid_of

_MANY = 200  # points: of more only the corners of their hull are kept
_MOST = 4_000_000  # distances of corners from planes: larger meshes are taken to have dents


@lru_cache(maxsize=1024)
def hull_of(mesh: Mesh) -> tuple[Floats, float]:
    """Points (k, 3) with the convex hull of a mesh, in its frame, and how deep (m) the surface lies below it at most.

    The depth is rough, 0 where the mesh is convex and inf where it is not closed: it says where the hull is good enough
    a bound.
    """
    return frozen(hull_corners(mesh.vertices[points_used(mesh)])), dent(mesh)


def hull_corners(points: Floats) -> Floats:
    """Of ``points`` (n, 3) fewer (k, 3) with the same convex hull; all different ones if they are few or in a plane."""
    points = points[distinct_rows(points)[0]]
    if len(points) < _MANY:
        return points
    from scipy.spatial import ConvexHull, QhullError  # 0.3 s to load

    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points


def dent(mesh: Mesh) -> float:
    """How deep (m) the surface of a mesh lies below its convex hull at most, roughly; inf where it is not closed.

    0 where it is convex: how far any corner rises above any triangle. Nothing in a mesh that is thinned lies deeper
    than half its size, which is enough to know of so large ones.
    """
    if mesh.radius:
        return 0.5 * float(np.ptp(mesh.vertices, axis=0).min())
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
