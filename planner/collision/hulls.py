"""The convex hulls of meshes, and how far the meshes lie below them."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from planner.base.arrays import Floats

_MANY = 40  # points: of more only the corners of their hull are kept
_CLOSED = 0.95  # share of its hull that a mesh with mere dents fills


def hull_corners(points: Floats) -> Floats:
    """Of ``points`` (n, 3) fewer (k, 3) with the same convex hull, where there are many."""
    if len(points) < _MANY:
        return points
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:  # they lie in a plane
        return np.unique(points, axis=0)


def dent(triangles: Floats) -> float:
    """How deep (m) the surface of closed ``triangles`` (m, 3, 3) lies below their convex hull; inf where it is open.

    0 where it is convex. At corners and middles of sides: it says where the hull is good enough a bound, no more.
    """
    try:
        hull = ConvexHull(triangles.reshape(-1, 3))
    except QhullError:
        return np.inf
    a, b, c = (triangles[:, k] - triangles[0, 0] for k in range(3))
    if abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6.0 < _CLOSED * hull.volume:
        return np.inf
    points = np.concatenate([triangles, 0.5 * (triangles + np.roll(triangles, 1, axis=1))]).reshape(-1, 3)
    above = points @ hull.equations[:, :3].T + hull.equations[:, 3]
    return max(0.0, -float(above.max(axis=1).min()))
