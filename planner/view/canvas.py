"""Objects in meshcat's viewer, recorded, and the page that replays them without a server."""

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
    *("page_robot.js", "page_roadmap.js", "page_pointer.js", "page_joints.js", "page_choice.js", "page_effort.js"),
    *("page_curve.js", "page_plots.js", "page_summary.js", "page_moving.js", "page_camera.js", "page_compare.js"),
    *("page_share.js", "page.js"),
)
_GZIP_SMALL = 6  # of text
_GZIP_LEVEL = 1  # of meshes: a higher one takes three times as long for at most 3 % fewer bytes
_LINES_OPACITY = 0.3
# three.js cylinders lie on y
_Z_FROM_Y = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


class Canvas:
    """A meshcat visualizer and its window, which records the commands; no server, no port, no browser."""

    def __init__(self) -> None:
        self.commands: list[dict[str, Any]] = []
        self._viewer = meshcat.Visualizer(window=self)

    def send(self, command: Any) -> None:
        """Record a command of the visualizer."""
        self.commands.append(command.lower())

    def shape(self, path: str, shape: Shape, placement: Floats, rgba: tuple[float, ...], *, flat: bool = False) -> None:
        """Draw a shape at a placement (4, 4) relative to the parent of ``path``, each triangle ``flat`` or smooth."""
        material: Any = g.MeshPhongMaterial(color=hex_colour(rgba), opacity=float(rgba[3]), flatShading=flat)
        self._object(path, g.Mesh(_geometry(shape), material))
        self.transform(path, placement @ _Z_FROM_Y if isinstance(shape, Cylinder) else placement)

    def points(self, path: str, positions: Floats, colours: Floats, size: float) -> None:
        """Draw dots (n, 3) with colours (n, 3); ``size`` in metres."""
        material: Any = g.PointsMaterial(size)
        self._object(path, g.Points(g.PointsGeometry(positions.T, colours.T), material))

    def segments(self, path: str, ends: Floats, colours: Floats) -> None:
        """Draw lines between consecutive pairs of ``ends`` (2 k, 3), all in one object."""
        material: Any = g.LineBasicMaterial(vertexColors=True, opacity=_LINES_OPACITY)
        self._object(path, g.LineSegments(g.PointsGeometry(_rounded(ends, 11).T, colours.T), material))

    def transform(self, path: str, matrix: Floats) -> None:
        """Place the object at ``path`` by ``matrix`` (4, 4)."""
        self._viewer[path].set_transform(np.asarray(matrix, dtype=float))

    def set(self, path: str, key: str, value: Any) -> None:
        """Set a property of an object of the viewer itself, for example ``visible``."""
        self._viewer[f"/{path}"].set_property(key, value)

    def pack(self) -> tuple[str, list[int]]:
        """All commands in MessagePack, one after another, as gzip in base64; and the length of each in bytes."""
        packages = [umsgpack.packb(command) for command in self.commands]
        return _packed(b"".join(packages)), [len(package) for package in packages]

    def _object(self, path: str, thing: g.Object) -> None:
        # meshcat draws identifiers from the clock; with names made of the path the same scene gives the same bytes
        thing.uuid, thing.geometry.uuid, thing.material.uuid = path, f"{path}.geometry", f"{path}.material"
        self._viewer[path].set_object(thing)


def render_page(canvas: Canvas, data: dict[str, Any], title: str) -> str:
    """A self-contained HTML page: the viewer, the recorded scene, our controls and ``data`` for them."""
    scene, lengths = canvas.pack()
    parts = {
        "TITLE": escape(title.encode("utf-8", "replace").decode()),  # half a surrogate pair is no text
        "STYLE": _assets("page.css"),
        "VIEWER": _viewer(),
        "SCRIPT": _packed(_assets(*_SCRIPTS).encode(), _GZIP_SMALL),
        "SCENE": scene,
        "DATA": _packed(json.dumps({**data, "lengths": lengths}, allow_nan=False).encode(), _GZIP_SMALL),
    }
    # one pass: the text of a part is not searched for placeholders, whatever a scene is called
    return re.sub(r"@@([A-Z]+)@@", lambda found: parts[found[1]], _assets("page.html"))


def _assets(*names: str) -> str:
    folder = resources.files("planner.view")
    return "".join((folder / name).read_text("utf-8") for name in names)


def _packed(content: bytes, level: int = _GZIP_LEVEL) -> str:
    """Gzip in base64, which may stand in any script element: the page unpacks it."""
    return base64.b64encode(gzip.compress(content, level, mtime=0)).decode()


@cache
def _viewer() -> str:
    """meshcat's own viewer, as its wheel ships it."""
    script = Path(meshcat.viewer_assets_path()) / "dist" / "main.min.js"
    return _packed(script.read_bytes(), _GZIP_SMALL)


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
            return g.TriangularMeshGeometry(_rounded(vertices, 14), triangles)


def _rounded(positions: Floats, bits: int) -> Floats:
    """Positions to the nearest 2**-bits m: gzip makes little of the zeros that this leaves in a float."""
    return np.round(positions * 2.0**bits) / 2.0**bits
