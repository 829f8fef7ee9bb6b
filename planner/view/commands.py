"""Commands to meshcat's viewer, as the plain data that it reads, and their MessagePack.

The viewer is JavaScript; meshcat's Python package would bring a server, a notebook and 0.1 s of imports with it. The
format is that package's own: the tests hold every command against what it sends for the same object. An object and its
parts speak of each other by names made of its path, so that the same scene gives the same bytes.
"""

from __future__ import annotations

import base64
import gzip
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import umsgpack

from planner.base.arrays import Floats, Ints

Command = dict[str, Any]

_WHITE = 0xFFFFFF
_FLOATS, _NUMBERS = ("Float32Array", 0x17), ("Uint32Array", 0x16)  # typed arrays and their MessagePack extensions
_BOTH_SIDES, _COLOURED_VERTICES = 2, 2  # three.js's numbers
_STANDING = np.eye(4).ravel().tolist()
_LEVEL = 1  # of gzip: a hundredth more bytes than at level 6, in a third of the time


def box(size: Sequence[float]) -> dict[str, Any]:
    """A box with sides of ``size`` (3,) m."""
    width, height, depth = (float(side) for side in size)
    return {"type": "BoxGeometry", "width": width, "height": height, "depth": depth}


def sphere(radius: float) -> dict[str, Any]:
    return {"type": "SphereGeometry", "radius": float(radius), "widthSegments": 20, "heightSegments": 20}


def cylinder(radius: float, length: float) -> dict[str, Any]:
    """A cylinder along y, as three.js has it."""
    ends = {"radiusTop": float(radius), "radiusBottom": float(radius)}
    return {"type": "CylinderGeometry", **ends, "height": float(length), "radialSegments": 50}


def triangles(vertices: Floats, corners: Ints) -> dict[str, Any]:
    """Triangles (m, 3) of ``vertices`` (n, 3)."""
    attributes = {"position": _array(vertices, _FLOATS)}
    return {"type": "BufferGeometry", "data": {"attributes": attributes, "index": _array(corners, _NUMBERS)}}


def coloured_points(positions: Floats, colours: Floats) -> dict[str, Any]:
    """Points (n, 3) with ``colours`` (n, 3)."""
    attributes = {"position": _array(positions, _FLOATS), "color": _array(colours, _FLOATS)}
    return {"type": "BufferGeometry", "data": {"attributes": attributes}}


def surface(colour: int, opacity: float) -> dict[str, Any]:
    """A shaded surface of one ``colour`` (0xrrggbb)."""
    return _material("MeshPhongMaterial", colour, opacity, coloured_vertices=False)


def lines(opacity: float) -> dict[str, Any]:
    """Lines in the colours of their ends."""
    return _material("LineBasicMaterial", _WHITE, opacity, coloured_vertices=True)


def dots(size: float) -> dict[str, Any]:
    """Dots of ``size`` (m) in the colours of the points."""
    return {"type": "PointsMaterial", "color": _WHITE, "size": float(size), "vertexColors": _COLOURED_VERTICES}


def set_object(path: str, kind: str, geometry: dict[str, Any], material: dict[str, Any]) -> Command:
    """Put an object of three.js's ``kind`` at ``path``."""
    parts = {name: f"{path}.{name}" for name in ("geometry", "material")}
    return {
        "type": "set_object",
        "object": {
            "metadata": {"version": 4.5, "type": "Object"},
            "geometries": [{"uuid": parts["geometry"], **geometry}],
            "materials": [{"uuid": parts["material"], **material}],
            "object": {"uuid": path, "type": kind, **parts, "matrix": _STANDING},
        },
        "path": path,
    }


def set_transform(path: str, matrix: Floats) -> Command:
    """Place what is at ``path`` by ``matrix`` (4, 4)."""
    columns = np.asarray(matrix, dtype=float).T.ravel()
    return {"type": "set_transform", "path": path, "matrix": columns.tolist()}


def set_property(path: str, key: str, value: Any) -> Command:
    return {"type": "set_property", "path": path, "property": key, "value": value}


def delete(path: str) -> Command:
    """Take away what is at ``path`` and below it."""
    return {"type": "delete", "path": path}


@dataclass(frozen=True)
class Packed:
    """Commands in MessagePack, one after another, gzipped (no time stamp), and the length of each in MessagePack."""

    content: bytes
    lengths: tuple[int, ...]

    @property
    def text(self) -> str:
        """The content in base64."""
        return base64.b64encode(self.content).decode()


def packed(commands: Sequence[Command], level: int = _LEVEL) -> Packed:
    """All ``commands`` as a page holds them, gzipped at a ``level`` of 1 to 9."""
    parts = [umsgpack.packb(command) for command in commands]
    return Packed(gzip.compress(b"".join(parts), level, mtime=0), tuple(len(part) for part in parts))


def _array(rows: Floats | Ints, kind: tuple[str, int]) -> dict[str, Any]:
    name, extension = kind
    content = np.ascontiguousarray(rows, dtype=np.float32 if kind is _FLOATS else np.uint32)
    data = umsgpack.Ext(extension, content.tobytes())
    return {"itemSize": content.shape[1], "type": name, "array": data, "normalized": False}


def _material(kind: str, colour: int, opacity: float, coloured_vertices: bool) -> dict[str, Any]:
    return {
        "type": kind,
        "color": colour,
        "reflectivity": 0.5,
        "side": _BOTH_SIDES,
        "transparent": opacity < 1.0,
        "opacity": opacity,
        "linewidth": 1.0,
        "wireframe": False,
        "wireframeLinewidth": 1.0,
        "vertexColors": _COLOURED_VERTICES if coloured_vertices else 0,
    }
