"""The bodies of a robot that are drawn, smoothed for the viewer, and kept in the user's cache folder.

Reading detailed meshes and smoothing them takes seconds, most of the time of a page. What is kept is found by a hash of
everything that it was made from, is only looked at, and may be deleted at any time.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from planner.base.arrays import frozen
from planner.base.cache import cache_folder
from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.base.hashing import content_hash
from planner.base.yamlfile import SMALLEST
from planner.models.files.urdf_geometry import visual_mesh_files
from planner.models.robot import Robot, load_visuals
from planner.models.shapes import Body, Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.view.canvas import Canvas
from planner.view.commands import Packed, packed
from planner.view.drawing import boxed, draw_visuals
from planner.view.surfaces import smoothed

T = TypeVar("T")

_FORMAT = 2  # of the files, of how meshes are smoothed, and of the viewer's commands
_LEVEL = 9  # of gzip: it is done once
_KEPT = 20  # robots
_SHAPES: dict[str, type[Any]] = {kind.__name__: kind for kind in (Box, Sphere, Cylinder, Capsule)}


@dataclass(frozen=True, eq=False)
class Visuals:
    """The visual bodies of a robot as a page takes them: commands that draw them, and ``boxes`` around them."""

    commands: Packed
    boxes: tuple[Body, ...]


def drawn_bodies(robot: Robot) -> tuple[Body, ...]:
    """The visual bodies of ``robot`` with smoothed meshes, see :func:`planner.models.robot.load_visuals`.

    Without what the robot carries.
    """
    return _kept(robot, _bodies)


def visuals_of(robot: Robot) -> Visuals:
    """The :func:`drawn_bodies` of ``robot``, ready for a page: they are packed once, when they are kept."""
    return _kept(robot, _visuals)


def _kept(robot: Robot, read: Callable[[Mapping[str, Any]], T]) -> T:
    """What ``read`` takes out of the robot's file in the cache, which is made where there is none, or a damaged one."""
    held = (*robot.joints, *sorted(robot.fixed_joints.items()))
    files = [np.frombuffer(file.read_bytes(), dtype=np.uint8) for file in visual_mesh_files(robot.source)]
    key = content_hash([_FORMAT, robot.source.xml, *held, robot.base, *files])
    path = cache_folder() / "visuals" / f"{key}.npz"
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return read(arrays)
    except Exception:  # of zip, NumPy, JSON or of what the numbers are given to: there is nothing that it may cost
        loaded = load_visuals(replace(robot, carried=()))
    arrays = _arrays(tuple(replace(body, shape=smoothed(body.shape)) for body in loaded))
    if loaded is not robot.bodies:  # what stands in for meshes that cannot be read
        _keep(path, arrays)
    return read(arrays)


def _bodies(arrays: Mapping[str, Any]) -> tuple[Body, ...]:
    rows = json.loads(str(arrays["bodies"]))
    return tuple(_body(row, arrays, k) for k, row in enumerate(rows))


def _visuals(arrays: Mapping[str, Any]) -> Visuals:
    lengths, placements, sizes = arrays["lengths"], arrays["placements"], np.maximum(arrays["sizes"], SMALLEST)
    boxes = [
        Body(row["name"], row["link"], row["joint"], Box(tuple(size)), frozen(placement), tuple(row["color"]))
        for row, size, placement in zip(json.loads(str(arrays["bodies"])), sizes.tolist(), placements, strict=True)
    ]
    return Visuals(Packed(arrays["commands"].tobytes(), tuple(lengths.tolist())), tuple(boxes))


def _arrays(bodies: tuple[Body, ...]) -> dict[str, Any]:
    """All that is kept of bodies: themselves, and what a page takes of them."""
    canvas, boxes = Canvas(), [boxed(body) for body in bodies]
    draw_visuals(canvas, bodies)
    commands = packed(canvas.commands, _LEVEL)
    arrays: dict[str, Any] = {
        "bodies": np.array(json.dumps([_row(body) for body in bodies])),
        "commands": np.frombuffer(commands.content, dtype=np.uint8),
        "lengths": np.array(commands.lengths, dtype=np.int64),
        "sizes": np.array([box.shape.size for box in boxes if isinstance(box.shape, Box)]).reshape(-1, 3),
        "placements": np.array([box.placement for box in boxes]).reshape(-1, 4, 4),
    }
    for k, body in enumerate(bodies):
        arrays[f"placement_{k}"] = body.placement
        if isinstance(body.shape, Mesh):
            arrays |= {f"vertices_{k}": body.shape.vertices, f"triangles_{k}": body.shape.triangles}
    return arrays


def _keep(path: Path, arrays: Mapping[str, Any]) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    # without a home, on a full disk: the next page takes as long as this one
    with contextlib.suppress(OSError, PlannerError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, buffer.getvalue())
        for old in sorted(path.parent.glob("*.npz"), key=os.path.getmtime)[:-_KEPT]:
            old.unlink()


def _row(body: Body) -> dict[str, Any]:
    shape = None if isinstance(body.shape, Mesh) else [type(body.shape).__name__, vars(body.shape)]
    return {"name": body.name, "link": body.link, "joint": body.joint, "color": body.color, "shape": shape}


def _body(row: dict[str, Any], arrays: Any, k: int) -> Body:
    shape: Shape
    if row["shape"] is None:
        shape = Mesh(arrays[f"vertices_{k}"], arrays[f"triangles_{k}"])
    else:
        kind, numbers = row["shape"]
        shape = _SHAPES[kind](**{name: tuple(v) if isinstance(v, list) else v for name, v in numbers.items()})
    return Body(row["name"], row["link"], row["joint"], shape, arrays[f"placement_{k}"], tuple(row["color"]))
