"""Objects on a canvas as commands to meshcat's viewer, and the page that replays them without a server."""

from __future__ import annotations

import json
import re
from functools import cache
from html import escape
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.models.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.view import commands
from planner.view.colours import hex_colour
from planner.view.surfaces import tube

_SCRIPTS = (  # one script, in this order, the last one after those of a live page
    *("page_robot.js", "page_roadmap.js", "page_pointer.js", "page_joints.js", "page_choice.js"),
    *("page_effort.js", "page_curve.js", "page_motion.js", "page_moving.js", "page_camera.js"),
)
_LIVE_SCRIPTS = ("live_gizmo.js", "live.js")
_LINES_OPACITY = 0.3
# three.js cylinders lie on y
_Z_FROM_Y = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


class Canvas:
    """Records what a meshcat viewer would be sent; no server, no port, no browser."""

    def __init__(self) -> None:
        self.commands: list[commands.Command] = []
        self._before: list[commands.Packed] = []

    def shape(self, path: str, shape: Shape, placement: Floats, rgba: tuple[float, ...]) -> None:
        """A shape as it is, at a placement (4, 4) relative to what ``path`` hangs under."""
        self._object(path, "Mesh", _geometry(shape), commands.surface(hex_colour(rgba), float(rgba[3])))
        self.place(path, shape, placement)

    def place(self, path: str, shape: Shape, placement: Floats) -> None:
        """Put a shape that is there to another placement (4, 4)."""
        self.transform(path, placement @ _Z_FROM_Y if isinstance(shape, Cylinder) else placement)

    def delete(self, path: str) -> None:
        """Take an object away, with all that hangs under it."""
        self.commands.append(commands.delete(_path(path)))

    def points(self, path: str, positions: Floats, colours: Floats, size: float) -> None:
        """Dots (n, 3) with colours (n, 3); ``size`` in metres."""
        self._object(path, "Points", commands.coloured_points(positions, colours), commands.dots(size))

    def segments(self, path: str, ends: Floats, colours: Floats) -> None:
        """Lines between consecutive pairs of ``ends`` (2 k, 3), all in one object."""
        self._object(path, "LineSegments", commands.coloured_points(ends, colours), commands.lines(_LINES_OPACITY))

    def transform(self, path: str, matrix: Floats) -> None:
        self.commands.append(commands.set_transform(_path(path), matrix))

    def set(self, path: str, key: str, value: Any) -> None:
        """A property of an object of the viewer's own, as ``visible``."""
        self.commands.append(commands.set_property(f"/{path.strip('/')}", key, value))

    def begin_with(self, kept: commands.Packed) -> None:
        """Send commands that were packed before, ahead of all others."""
        self._before.append(kept)

    def packed(self) -> tuple[str, list[tuple[int, ...]]]:
        """All commands as a page holds them: a line of base64 for each package, and the lengths of its commands."""
        packages = [*self._before, commands.packed(self.commands)]
        return "\n".join(package.text for package in packages), [package.lengths for package in packages]

    def _object(self, path: str, kind: str, geometry: dict[str, Any], material: dict[str, Any]) -> None:
        self.commands.append(commands.set_object(_path(path), kind, geometry, material))


def render_page(canvas: Canvas, data: dict[str, Any], title: str, live: bool = False) -> str:
    """A self-contained HTML page: the viewer, the recorded scene, our controls and ``data`` for them.

    A ``live`` one talks to the server that it comes from; any other is allowed no connection.
    """
    scene, lengths = canvas.packed()
    parts = {
        "CONNECT": "; connect-src 'self'" if live else "",
        "LIVE": _assets("live.html") if live else "",
        "TITLE": escape(title.encode("utf-8", "replace").decode()),  # half a surrogate pair is no text
        "STYLE": _assets("page.css", *(["live.css"] if live else [])),
        "VIEWER": _viewer_script(),
        "SCRIPT": _assets(*_SCRIPTS, *(_LIVE_SCRIPTS if live else ()), "page.js"),
        "SCENE": scene,
        "DATA": script_json({**data, "lengths": lengths}),
    }
    # one pass: what stands in for a placeholder is not searched for placeholders again, whatever a scene is called
    return re.sub(r"@@([A-Z]+)@@", lambda found: parts[found[1]], _assets("page.html"))


def _assets(*names: str) -> str:
    folder = resources.files("planner.view")
    return "".join((folder / name).read_text("utf-8") for name in names)


def script_json(data: Any) -> str:
    """JSON that may stand in any script element: no text in it ends the element, opens a comment in it or a line.

    Raises ValueError for a number that is not finite.
    """
    # json escapes all that is not ASCII, with it U+2028 and U+2029 and halves of surrogate pairs
    text = json.dumps(data, allow_nan=False, ensure_ascii=True)
    return text.translate({ord(c): f"\\u{ord(c):04x}" for c in "<>&"})


@cache
def _viewer_script() -> str:
    """meshcat's own viewer, as its wheel ships it; its licence note is kept at its head.

    Found without running the package. Raises ImportError where it is not installed.
    """
    package = find_spec("meshcat")
    if package is None or package.origin is None:
        raise ImportError("no module named 'meshcat'")
    folder = Path(package.origin).parent / "viewer" / "dist"
    return (folder / "main.min.js").read_text("utf-8").replace("</script>", "<\\/script>")


def _path(path: str) -> str:
    return f"/meshcat/{path.strip('/')}"


def _geometry(shape: Shape) -> dict[str, Any]:
    match shape:
        case Box(size):
            return commands.box(size)
        case Sphere(radius):
            return commands.sphere(radius)
        case Cylinder(radius, length):
            return commands.cylinder(radius, length)
        case Capsule():
            return _geometry(_capsule(shape))
        case Mesh(vertices, triangles):
            return commands.triangles(vertices, triangles)


def _capsule(shape: Capsule) -> Mesh:
    """A tube whose ends are drawn in to half spheres."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 16)
    z = shape.radius * np.sin(angle) + np.where(angle < 0, -0.5, 0.5) * shape.length
    radius = np.maximum(shape.radius * np.cos(angle), 1e-6)
    straight = tube(np.column_stack([0 * z, 0 * z, z]), 1.0, 20)
    vertices = straight.vertices.copy()
    vertices[:, :2] *= np.repeat(radius, 20)[:, None]
    return Mesh(vertices, straight.triangles)
