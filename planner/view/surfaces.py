"""Triangles and colours: smooth surfaces, tubes along paths, numbers as colours."""

import numpy as np

from planner.base.arrays import Floats
from planner.robot.files.meshes import split_at_creases
from planner.robot.shapes import Capsule, Mesh, Shape

# dark blue to yellow with linear lightness, so that the order survives a black and white print
_STOPS = np.array([[0.16, 0.11, 0.33], [0.20, 0.32, 0.55], [0.13, 0.54, 0.55], [0.38, 0.74, 0.38], [0.98, 0.88, 0.22]])


def smooth_mesh(shape: Shape) -> Shape:
    """Return the shape; a mesh shares vertices between smoothly joined faces only."""
    return split_at_creases(shape) if isinstance(shape, Mesh) else shape


def _unit(vectors: Floats) -> Floats:
    with np.errstate(invalid="ignore", divide="ignore"):
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def tube(points: Floats, radius: float, sides: int = 10) -> Mesh:
    """Return a tube around a polyline (n, 3): browsers draw lines one pixel wide."""
    moved = np.concatenate([[True], np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-6])
    points = points[moved]
    if len(points) < 2:
        points = np.vstack([points[0], points[0] + [0, 0, 1e-4]])
    ahead = np.gradient(points, axis=0)
    back = np.linalg.norm(ahead, axis=1) < 1e-12  # the line reverses here
    ahead[back] = np.diff(points, axis=0, append=points[-1:])[back]
    ahead = _unit(ahead)
    side = np.empty_like(ahead)
    side[0] = _unit(np.cross(ahead[:1], np.eye(3)[[int(np.argmin(np.abs(ahead[0])))]]))[0]
    for k in range(1, len(points)):
        # parallel transport, so that the tube does not twist
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


def capsule_mesh(shape: Capsule) -> Mesh:
    """Return a capsule as a tube with half spheres as ends."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 16)
    z = shape.radius * np.sin(angle) + np.where(angle < 0, -0.5, 0.5) * shape.length
    radius = np.maximum(shape.radius * np.cos(angle), 1e-6)
    straight = tube(np.column_stack([0 * z, 0 * z, z]), 1.0, 20)
    vertices = straight.vertices.copy()
    vertices[:, :2] *= np.repeat(radius, 20)[:, None]
    return Mesh(vertices, straight.triangles)


def ramp_stops() -> list[list[float]]:
    """Return the colour ramp as red, green, blue in [0, 1] at evenly spaced values."""
    return _STOPS.tolist()


def css_gradient() -> str:
    """Return the ramp as a CSS gradient, for a legend."""
    stops = ", ".join("#" + "".join(f"{round(255 * c):02x}" for c in stop) for stop in _STOPS)
    return f"linear-gradient(to right, {stops})"


def hex_colour(rgb: tuple[float, ...] | Floats) -> int:
    """Return red, green, blue in [0, 1] as the number 0xrrggbb."""
    red, green, blue = (round(255 * float(value)) for value in rgb[:3])
    return (red << 16) + (green << 8) + blue
