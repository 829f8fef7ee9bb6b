"""The bodies of a robot that are drawn, smoothed for the viewer, and kept in the user's cache.

Reading detailed meshes and smoothing them takes seconds, most of the time of a page. They are kept twice: as bodies,
and as what a page takes of these.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner.base.cache import cached
from planner.models.files.urdf_geometry import mesh_files
from planner.models.robot import Robot, load_visuals
from planner.models.shapes import Body, Box, Capsule, Cylinder, Mesh, Sphere
from planner.view.canvas import Canvas
from planner.view.commands import Packed, packed
from planner.view.drawing import boxed, draw_visuals
from planner.view.surfaces import smoothed

_FORMAT = 3  # of the arrays, of how meshes are smoothed, and of the viewer's commands
_LEVEL = 9  # of gzip: it is done once
_SHAPES: dict[str, type[Any]] = {kind.__name__: kind for kind in (Box, Sphere, Cylinder, Capsule)}


class _StandIns(Exception):
    """The meshes cannot be read: what stands in for them is not kept."""


@dataclass(frozen=True, eq=False)
class Visuals:
    """The visual bodies of a robot as a page takes them: commands that draw them, and ``boxes`` around them."""

    commands: Packed
    boxes: tuple[Body, ...]


def drawn_bodies(robot: Robot) -> tuple[Body, ...]:
    """The visual bodies of ``robot`` with smoothed meshes, see :func:`planner.models.robot.load_visuals`.

    Without what the robot carries.
    """
    return _bodies(_kept(robot, "bodies", _arrays))


def visuals_of(robot: Robot) -> Visuals:
    """The :func:`drawn_bodies` of ``robot``, ready for a page: they are packed once, when they are kept."""
    arrays = _kept(robot, "page", _page_arrays)
    return Visuals(Packed(arrays["commands"].tobytes(), tuple(arrays["lengths"].tolist())), _bodies(arrays))


def _kept(robot: Robot, what: str, arrays_of: Callable[[Iterable[Body]], dict[str, Any]]) -> Mapping[str, Any]:
    """What is made of the smoothed bodies, out of the cache where it is there."""
    held = (*robot.joints, *sorted(robot.fixed_joints.items()))
    files = [np.frombuffer(file.read_bytes(), dtype=np.uint8) for file in mesh_files(robot.source, "visual")]

    def make() -> dict[str, Any]:
        loaded = load_visuals(replace(robot, carried=()))
        if loaded is robot.bodies:
            raise _StandIns
        return arrays_of(replace(body, shape=smoothed(body.shape)) for body in loaded)

    try:
        return cached("visuals", [_FORMAT, what, robot.source.xml, *held, robot.base, *files], make)
    except _StandIns:
        return arrays_of(replace(body, shape=smoothed(body.shape)) for body in robot.bodies)


def _page_arrays(bodies: Iterable[Body]) -> dict[str, Any]:
    canvas, drawn = Canvas(), list(bodies)
    draw_visuals(canvas, drawn)
    commands = packed(canvas.commands, _LEVEL)
    content, lengths = np.frombuffer(commands.content, dtype=np.uint8), np.array(commands.lengths, dtype=np.int64)
    return {"commands": content, "lengths": lengths, **_arrays(map(boxed, drawn))}


def _arrays(bodies: Iterable[Body]) -> dict[str, Any]:
    """Bodies as arrays by name: one with text, one with a placement for each, and those of the meshes."""
    rows: list[dict[str, Any]] = []
    arrays: dict[str, Any] = {}
    for k, body in enumerate(bodies):
        shape = None if isinstance(body.shape, Mesh) else [type(body.shape).__name__, *vars(body.shape).values()]
        rows.append({"name": body.name, "link": body.link, "joint": body.joint, "color": body.color, "shape": shape})
        arrays[f"placement_{k}"] = body.placement
        if isinstance(body.shape, Mesh):
            arrays |= {f"vertices_{k}": body.shape.vertices, f"triangles_{k}": body.shape.triangles}
    return {"bodies": np.frombuffer(json.dumps(rows).encode(), dtype=np.uint8), **arrays}


def _bodies(arrays: Mapping[str, Any]) -> tuple[Body, ...]:
    """The bodies that :func:`_arrays` was given."""
    found = []
    for k, row in enumerate(json.loads(arrays["bodies"].tobytes())):
        if row["shape"] is None:
            shape = Mesh(arrays[f"vertices_{k}"], arrays[f"triangles_{k}"])
        else:
            kind, *numbers = row["shape"]
            shape = _SHAPES[kind](*(tuple(v) if isinstance(v, list) else v for v in numbers))
        about = {**row, "color": tuple(row["color"]), "shape": shape}
        found.append(Body(placement=arrays[f"placement_{k}"], **about))
    return tuple(found)
