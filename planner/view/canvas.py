"""The door to meshcat: objects as viewer commands, and the page that replays them without a server."""

from __future__ import annotations

import base64
import gzip
import json
import re
from functools import cache
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

import meshcat
import meshcat.geometry as g
import numpy as np
import umsgpack
from meshcat.commands import Delete, SetObject, SetProperty, SetTransform
from meshcat.path import Path as ScenePath

from planner.base.arrays import Floats
from planner.view.colours import hex_colour
from planner.view.surfaces import tube
from planner.world.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere

_SCRIPTS = (  # one script, in this order, the last one after those of a live page
    *("page_robot.js", "page_roadmap.js", "page_pointer.js"),
    *("page_joints.js", "page_choice.js", "page_effort.js", "page_curve.js", "page_motion.js", "page_moving.js"),
)
_LIVE_SCRIPTS = ("live_gizmo.js", "live.js")
_REFERENCES = ("uuid", "geometry", "material")  # keys by which a command's parts speak of each other
_Z_FROM_Y = np.array(
    [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float
)  # three.js cylinders lie on y


class Canvas:
    """Records what a meshcat viewer would be sent; no server, no port, no browser."""

    def __init__(self) -> None:
        self.commands: list[dict[str, Any]] = []
        self._numbers: dict[str, str] = {}

    def shape(self, path: str, shape: Shape, placement: Floats, rgba: tuple[float, ...]) -> None:
        """A shape as it is, at a placement (4, 4) relative to what ``path`` hangs under."""
        self._send(SetObject(_geometry(shape), _material(rgba), _path(path)))
        self.place(path, shape, placement)

    def place(self, path: str, shape: Shape, placement: Floats) -> None:
        """Put a shape that is there to another placement (4, 4)."""
        self.transform(path, placement @ _Z_FROM_Y if isinstance(shape, Cylinder) else placement)

    def delete(self, path: str) -> None:
        """Take an object away, with all that hangs under it."""
        self._send(Delete(_path(path)))

    def points(self, path: str, positions: Floats, colours: Floats, size: float) -> None:
        """Dots (n, 3) with colours (n, 3); ``size`` in metres."""
        geometry = g.PointsGeometry(_columns(positions), _columns(colours))
        material: Any = g.PointsMaterial(size=float(size))
        self._send(SetObject(g.Points(geometry, material), None, _path(path)))

    def segments(self, path: str, ends: Floats, colours: Floats) -> None:
        """Lines between consecutive pairs of ``ends`` (2 k, 3), all in one object."""
        geometry = g.PointsGeometry(_columns(ends), _columns(colours))
        material: Any = g.LineBasicMaterial(vertexColors=True, transparent=True, opacity=0.3)
        self._send(SetObject(g.LineSegments(geometry, material), None, _path(path)))

    def transform(self, path: str, matrix: Floats) -> None:
        self._send(SetTransform(np.asarray(matrix, dtype=float), _path(path)))

    def set(self, path: str, key: str, value: Any) -> None:
        """A property of an object, as ``visible``."""
        self._send(SetProperty(key.encode().decode(), value, ScenePath(tuple(path.strip("/").split("/")))))

    def _send(self, command: Any) -> None:
        self.commands.append(self._numbered(command.lower()))

    def _numbered(self, value: Any) -> Any:
        """``value`` with meshcat's random identifiers replaced by numbers: the same scene gives the same bytes."""
        if isinstance(value, dict):
            return {k: self._number(v) if k in _REFERENCES else self._numbered(v) for k, v in value.items()}
        return [self._numbered(item) for item in value] if isinstance(value, list) else value

    def _number(self, value: Any) -> Any:
        return self._numbers.setdefault(value, str(len(self._numbers))) if isinstance(value, str) else value

    def packed(self, level: int = 6) -> tuple[str, list[int]]:
        """All commands in MessagePack, one after another, gzipped (no time stamp) in base64; and their lengths."""
        parts = [umsgpack.packb(command) for command in self.commands]
        return base64.b64encode(gzip.compress(b"".join(parts), level, mtime=0)).decode(), [len(part) for part in parts]


def render_page(canvas: Canvas, data: dict[str, Any], title: str, live: bool = False) -> str:
    """A self-contained HTML page: the viewer, the recorded scene, our controls and ``data`` for them.

    A ``live`` one talks to the server that it comes from; any other is allowed no connection.
    """
    folder = resources.files("planner.view")
    scene, lengths = canvas.packed(1 if live else 6)
    data = {**data, "lengths": lengths}
    scripts = (*_SCRIPTS, *(_LIVE_SCRIPTS if live else ()), "page.js")
    parts = {
        "CONNECT": "; connect-src 'self'" if live else "",
        "LIVE": (folder / "live.html").read_text("utf-8") if live else "",
        "TITLE": escape(title.encode("utf-8", "replace").decode()),  # half a surrogate pair is no text
        "STYLE": "".join((folder / name).read_text("utf-8") for name in ("page.css", *(("live.css",) if live else ()))),
        "VIEWER": _viewer_script(),
        "SCRIPT": "".join((folder / name).read_text("utf-8") for name in scripts),
        "SCENE": scene,
        "DATA": script_json(data),
    }
    page = (folder / "page.html").read_text("utf-8")
    # one pass: what stands in for a placeholder is not searched for placeholders again, whatever a scene is called
    return re.sub(r"@@([A-Z]+)@@", lambda found: parts[found[1]], page)


def script_json(data: Any) -> str:
    """JSON that may stand in any script element: no text in it ends the element, opens a comment in it or a line.

    Raises ValueError for a number that is not finite.
    """
    # json escapes all that is not ASCII, with it U+2028 and U+2029 and halves of surrogate pairs
    text = json.dumps(data, allow_nan=False, ensure_ascii=True)
    return text.translate({ord(c): f"\\u{ord(c):04x}" for c in "<>&"})


@cache
def _viewer_script() -> str:
    """meshcat's own viewer, as its wheel ships it; its licence note is kept at its head."""
    folder = Path(meshcat.__file__).parent / "viewer" / "dist"
    return (folder / "main.min.js").read_text("utf-8").replace("</script>", "<\\/script>")


def _path(path: str) -> ScenePath:
    return ScenePath(("meshcat", *path.strip("/").split("/")))


def _columns(rows: Floats) -> Any:
    return np.ascontiguousarray(np.asarray(rows, dtype=np.float32).T)


def _material(rgba: tuple[float, ...]) -> Any:
    opacity = float(rgba[3])
    return g.MeshPhongMaterial(color=hex_colour(rgba), opacity=opacity, transparent=opacity < 1.0)


def _triangles(mesh: Mesh) -> Any:
    return g.TriangularMeshGeometry(mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32))


def _geometry(shape: Shape) -> Any:
    match shape:
        case Box(size):
            return g.Box([float(side) for side in size])
        case Sphere(radius):
            return g.Sphere(float(radius))
        case Cylinder(radius, length):
            return g.Cylinder(float(length), float(radius))
        case Capsule():
            return _triangles(_capsule(shape))
        case Mesh():
            return _triangles(shape)


def _capsule(shape: Capsule) -> Mesh:
    """A tube whose ends are drawn in to half spheres."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 16)
    z = shape.radius * np.sin(angle) + np.where(angle < 0, -0.5, 0.5) * shape.length
    radius = np.maximum(shape.radius * np.cos(angle), 1e-6)
    straight = tube(np.column_stack([0 * z, 0 * z, z]), 1.0, 20)
    vertices = straight.vertices.copy()
    vertices[:, :2] *= np.repeat(radius, 20)[:, None]
    return Mesh(vertices, straight.triangles)
