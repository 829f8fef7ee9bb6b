"""Objects recorded for meshcat's viewer, and the page that replays them without a server."""

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

from planner.base.arrays import Floats
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.view.surfaces import capsule_mesh, hex_colour

_SCRIPTS = (  # one script, in this order
    *("page_robot.js", "page_roadmap.js", "page_pointer.js", "page_joints.js", "page_choice.js", "page_rounds.js"),
    *("page_curve.js", "page_plots.js", "page_summary.js", "page_moving.js", "page_camera.js", "page_compare.js"),
    *("page_share.js", "page.js"),
)
_GZIP_SMALL = 6  # of text
_GZIP_LEVEL = 1  # of meshes: higher levels take three times as long for at most 3 % fewer bytes
_LINES_OPACITY = 0.3
# three.js cylinders lie on y
_Z_FROM_Y = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


class Canvas:
    """A meshcat visualizer with itself as window, which records the commands; no server, port or browser."""

    def __init__(self) -> None:
        self.commands: list[dict[str, Any]] = []
        self._viewer = meshcat.Visualizer(window=self)

    def send(self, command: Any) -> None:
        """Record a command of the visualizer."""
        self.commands.append(command.lower())

    def shape(self, path: str, shape: Shape, placement: Floats, rgba: tuple[float, ...], *, flat: bool = False) -> None:
        """Draw a shape at a placement (4, 4) relative to its parent; with ``flat`` each triangle is flat."""
        material: Any = g.MeshPhongMaterial(color=hex_colour(rgba), opacity=float(rgba[3]), flatShading=flat)
        self._object(path, g.Mesh(_geometry(shape), material))
        self.transform(path, placement @ _Z_FROM_Y if isinstance(shape, Cylinder) else placement)

    def points(self, path: str, positions: Floats, colours: Floats, size: float) -> None:
        """Draw dots (n, 3) with colours (n, 3) and ``size`` in metres."""
        material: Any = g.PointsMaterial(size)
        self._object(path, g.Points(g.PointsGeometry(positions.T, colours.T), material))

    def segments(self, path: str, ends: Floats, colours: Floats) -> None:
        """Draw lines between consecutive pairs of ``ends`` (2 k, 3) as one object."""
        material: Any = g.LineBasicMaterial(vertexColors=True, opacity=_LINES_OPACITY)
        self._object(path, g.LineSegments(g.PointsGeometry(_round(ends, 11).T, colours.T), material))

    def transform(self, path: str, matrix: Floats) -> None:
        """Place the object at ``path`` by ``matrix`` (4, 4)."""
        self._viewer[path].set_transform(np.asarray(matrix, dtype=float))

    def set(self, path: str, key: str, value: Any) -> None:
        """Set a property of an object of the viewer itself, for example ``visible``."""
        self._viewer[f"/{path}"].set_property(key, value)

    def pack(self) -> tuple[str, list[int]]:
        """Return all commands in MessagePack as gzip in base64, and the length of each in bytes."""
        packages = [umsgpack.packb(command) for command in self.commands]
        return _compress(b"".join(packages)), [len(package) for package in packages]

    def _object(self, path: str, thing: g.Object) -> None:
        # meshcat's identifiers depend on the clock; these depend on the path, so that pages are reproducible
        thing.uuid, thing.geometry.uuid, thing.material.uuid = path, f"{path}.geometry", f"{path}.material"
        self._viewer[path].set_object(thing)


def render_page(canvas: Canvas, data: dict[str, Any], title: str) -> str:
    """Return a self-contained HTML page: the viewer, the recorded scene, the controls and their ``data``."""
    scene, lengths = canvas.pack()
    parts = {
        "TITLE": escape(title.encode("utf-8", "replace").decode()),  # half a surrogate pair is no text
        "STYLE": _read_assets("page.css"),
        "VIEWER": _viewer(),
        "SCRIPT": _compress(_read_assets(*_SCRIPTS).encode(), _GZIP_SMALL),
        "SCENE": scene,
        "DATA": _compress(json.dumps({**data, "lengths": lengths}, allow_nan=False).encode(), _GZIP_SMALL),
    }
    # one pass, so that a scene's name cannot hold a placeholder
    return re.sub(r"@@([A-Z]+)@@", lambda match: parts[match[1]], _read_assets("page.html"))


def _read_assets(*names: str) -> str:
    folder = resources.files("planner.view")
    return "".join((folder / name).read_text("utf-8") for name in names)


def _compress(content: bytes, level: int = _GZIP_LEVEL) -> str:
    """Return gzip in base64, which any script element may hold: the page unpacks it."""
    return base64.b64encode(gzip.compress(content, level, mtime=0)).decode()


@cache
def _viewer() -> str:
    """Return meshcat's own viewer of its wheel."""
    script = Path(meshcat.viewer_assets_path()) / "dist" / "main.min.js"
    return _compress(script.read_bytes(), _GZIP_SMALL)


def _geometry(shape: Shape) -> g.Geometry:
    match shape:
        case Box(size):
            return g.Box([float(side) for side in size])
        case Sphere(radius):
            return g.Sphere(float(radius))
        case Cylinder(radius, length):
            return g.Cylinder(float(length), float(radius))
        case Capsule():
            return _geometry(capsule_mesh(shape))
        case Mesh(vertices, triangles):
            return g.TriangularMeshGeometry(_round(vertices, 14), triangles)


def _round(positions: Floats, bits: int) -> Floats:
    """Return positions rounded to 2**-bits m: gzip compresses the zero bits."""
    return np.round(positions * 2.0**bits) / 2.0**bits
