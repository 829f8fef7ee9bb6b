"""Triangles to look at: smooth where a surface is smooth, sharp where it has an edge; tubes along paths."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints, distinct_rows
from planner.models.shapes import Mesh, Shape

_CREASE = np.cos(np.radians(35.0))  # faces that meet at more than this stay sharp


def smoothed(shape: Shape) -> Shape:
    """The shape as a viewer wants it: a mesh :func:`creased`, others as they are."""
    return creased(shape) if isinstance(shape, Mesh) else shape


def creased(mesh: Mesh) -> Mesh:
    """The mesh with vertices shared where faces join smoothly and split where they meet at an edge.

    The viewer averages normals over shared vertices: triangle soup looks faceted, welded soup looks melted.
    """
    corners = mesh.vertices[mesh.triangles]  # (m, 3, 3)
    normals = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    keep = np.isfinite(normals).all(axis=1)
    corners, normals = corners[keep], normals[keep]
    if not len(corners):
        return mesh
    points = corners.reshape(-1, 3)
    _, welded = distinct_rows(np.round(points * 1e5).astype(np.int64))  # to a hundredth of a millimetre
    smooth = _corner_normals(welded, np.repeat(normals, 3, axis=0))
    first, index = distinct_rows(np.column_stack([welded, np.round(smooth * 50)]).astype(np.int64))
    return Mesh(points[first], index.reshape(-1, 3))


def _corner_normals(welded: Ints, normals: Floats) -> Floats:
    """At each corner the mean normal of the faces around its point that lie within the crease angle of its own."""
    order = np.argsort(welded, kind="stable")
    counts = np.bincount(welded)
    first = np.cumsum(counts) - counts
    repeat = counts[welded]
    a = np.repeat(np.arange(len(welded)), repeat)
    offset = np.arange(len(a)) - np.repeat(np.cumsum(repeat) - repeat, repeat)
    b = order[np.repeat(first[welded], repeat) + offset]
    near = np.einsum("ij,ij->i", normals[a], normals[b]) > _CREASE
    total = np.zeros_like(normals)
    np.add.at(total, a[near], normals[b[near]])
    return _unit(total)


def _unit(vectors: Floats) -> Floats:
    with np.errstate(invalid="ignore", divide="ignore"):
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def tube(points: Floats, radius: float, sides: int = 10) -> Mesh:
    """A tube around a polyline (n, 3): lines are one pixel wide in a browser, whatever width is asked for."""
    moved = np.concatenate([[True], np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-6])
    points = points[moved]
    if len(points) < 2:
        points = np.vstack([points[0], points[0] + [0, 0, 1e-4]])
    ahead = np.gradient(points, axis=0)
    back = np.linalg.norm(ahead, axis=1) < 1e-12  # the line turns right back here
    ahead[back] = np.diff(points, axis=0, append=points[-1:])[back]
    ahead = _unit(ahead)
    side = np.empty_like(ahead)
    side[0] = _unit(np.cross(ahead[:1], np.eye(3)[[int(np.argmin(np.abs(ahead[0])))]]))[0]
    for k in range(1, len(points)):
        # carried along without turning about the path, so that the tube does not twist
        across = side[k - 1] - (side[k - 1] @ ahead[k]) * ahead[k]
        side[k] = across / max(float(np.linalg.norm(across)), 1e-12)
    other = np.cross(ahead, side)
    angle = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    ring = np.cos(angle)[:, None, None] * side + np.sin(angle)[:, None, None] * other
    vertices = (points + radius * ring).transpose(1, 0, 2).reshape(-1, 3)
    k = np.arange(len(points) - 1)[:, None] * sides
    s = np.arange(sides)[None]
    a, b = k + s, k + (s + 1) % sides
    triangles = np.concatenate([np.stack([a, b, a + sides], -1), np.stack([b, b + sides, a + sides], -1)])
    return Mesh(vertices, triangles.reshape(-1, 3))
