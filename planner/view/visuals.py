"""The bodies of a robot on a page: smoothed for the viewer, and kept in the user's cache.

Reading detailed meshes and smoothing them takes seconds, most of the time of a page.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.cache import cached
from planner.robot.files.urdf_geometry import mesh_files
from planner.robot.robot import Robot, load_visuals
from planner.robot.shapes import Body, Box, Capsule, Cylinder, Mesh, Sphere
from planner.view.canvas import Canvas
from planner.view.drawing import draw_bodies, place_joints
from planner.view.surfaces import smoothed

_FORMAT = 7  # of the arrays, and of how meshes are smoothed
_SHAPES: dict[str, type[Any]] = {kind.__name__: kind for kind in (Box, Sphere, Cylinder, Capsule)}


class _StandIns(Exception):
    """The meshes cannot be read: what stands in for them is not kept."""


def draw_robot(
    canvas: Canvas, robot: Robot, q: Floats, touching: Set[str] = frozenset()
) -> tuple[dict[str, str], tuple[Body, ...]]:
    """Draw the robot at ``q`` (dof,), links in ``touching`` red: bodies to look at, and under the same frames those
    that collide.

    Returns the links by path, and the bodies to look at.
    """
    carried = _smoothed(robot.carried)
    visual, colliding = ((*bodies, *carried) for bodies in drawn_bodies(robot))
    names = draw_bodies(canvas, "visual", visual, touching)
    names |= draw_bodies(canvas, "collision", colliding, touching)
    place_joints(canvas, robot, q)
    return names, visual


def drawn_bodies(robot: Robot) -> tuple[tuple[Body, ...], tuple[Body, ...]]:
    """The visual bodies of ``robot``, see :func:`planner.robot.robot.load_visuals`, and those that collide.

    With smoothed meshes, and without the bodies that the robot carries. They come from the cache where it has them.
    """
    own = _own(robot)
    made_of = [_FORMAT, robot.source.xml, *robot.joints, *sorted(robot.fixed_joints.items()), robot.base]
    made_of += [_stamp(file) for file in mesh_files(robot.source, "visual")]
    made_of += [part for body in own for part in (body.placement, *body.shape.content())]

    def make() -> dict[str, Any]:
        loaded = load_visuals(replace(robot, carried=()))
        if loaded is robot.bodies:
            raise _StandIns
        return _arrays(_smoothed([*loaded, *own]))

    try:
        bodies = _bodies(cached("drawn", made_of, make))
    except _StandIns:
        bodies = tuple(_smoothed([*own, *own]))
    visual = len(bodies) - len(own)
    return bodies[:visual], bodies[visual:]


def _own(robot: Robot) -> list[Body]:
    """The bodies that collide, without what the robot carries."""
    carried = {body.link for body in robot.carried}
    return [body for body in robot.bodies if body.link not in carried]


def _smoothed(bodies: Iterable[Body]) -> list[Body]:
    return [replace(body, shape=smoothed(body.shape)) for body in bodies]


def _stamp(file: Path) -> tuple[str, int, int, int]:
    """What changes whenever a file does: reading detailed meshes to hash them would take longer than what is kept."""
    found = file.stat()
    return (str(file), found.st_ino, found.st_size, found.st_ctime_ns)


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
