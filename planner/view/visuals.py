"""The bodies of a robot that are drawn, smoothed for the viewer, and kept in the user's cache folder.

Reading detailed meshes and smoothing them takes seconds, most of the time of a page. What is kept is found by a hash of
everything that it was made from, is only looked at, and may be deleted at any time.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.base.hashing import content_hash
from planner.view.surfaces import smoothed
from planner.world.robot import Robot, load_visuals
from planner.world.shapes import Body, Box, Capsule, Cylinder, Mesh, Shape, Sphere
from planner.world.urdf import visual_mesh_files

_FORMAT = 1  # of the files, and of how meshes are smoothed
_KEPT = 20  # robots
_SHAPES: dict[str, type[Any]] = {kind.__name__: kind for kind in (Box, Sphere, Cylinder, Capsule)}
_DAMAGE = (OSError, EOFError, ValueError, LookupError, TypeError, zipfile.BadZipFile)


def drawn_bodies(robot: Robot) -> tuple[Body, ...]:
    """The visual bodies of ``robot`` with smoothed meshes, see :func:`planner.world.robot.load_visuals`."""
    held = (*robot.joints, *sorted(robot.fixed_joints.items()))
    files = [np.frombuffer(file.read_bytes(), dtype=np.uint8) for file in visual_mesh_files(robot.source)]
    key = content_hash([_FORMAT, robot.source.xml, *held, robot.base, *files])
    kept = _folder() / f"{key}.npz"
    found = _read(kept)
    if found is None:
        loaded = load_visuals(replace(robot, carried=()))
        found = tuple(replace(body, shape=smoothed(body.shape)) for body in loaded)
        if loaded is not robot.bodies:  # what stands in for meshes that cannot be read
            _keep(kept, found)
    return (*found, *(replace(body, shape=smoothed(body.shape)) for body in robot.carried))


def _folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(base) / "planner" / "visuals"


def _read(path: Path) -> tuple[Body, ...] | None:
    """What was kept; None where nothing is, or where it cannot be read."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            rows = json.loads(str(arrays["bodies"]))
            return tuple(_body(row, arrays, k) for k, row in enumerate(rows))
    except _DAMAGE:
        return None


def _keep(path: Path, bodies: tuple[Body, ...]) -> None:
    arrays: dict[str, Any] = {"bodies": np.array(json.dumps([_row(body) for body in bodies]))}
    for k, body in enumerate(bodies):
        arrays[f"placement_{k}"] = body.placement
        if isinstance(body.shape, Mesh):
            arrays |= {f"vertices_{k}": body.shape.vertices, f"triangles_{k}": body.shape.triangles}
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
