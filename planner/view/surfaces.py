"""Triangles to look at: smooth where a surface is smooth, sharp where it has an edge; tubes along paths."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats
from planner.robot.files.meshes import split_at_creases
from planner.robot.shapes import Mesh, Shape

_CREASE = np.radians(35.0)  # an edge at which faces meet at a larger angle stays sharp


def smoothed(shape: Shape) -> Shape:
    """The shape, a mesh with vertices shared where faces join smoothly and split where they meet at an edge.

    The viewer averages normals over shared vertices: triangle soup looks faceted, welded soup looks melted.
    """
    if not isinstance(shape, Mesh):
        return shape
    return split_at_creases(shape, _CREASE)


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
