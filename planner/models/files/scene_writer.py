"""A scene as a file of our own format, with its meshes beside it."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from planner.base.arrays import Floats
from planner.base.errors import SceneError
from planner.base.files import StrPath, make_folder, write_whole
from planner.models.moving import MovingObstacle
from planner.models.poses import quaternion_of
from planner.models.scene import Scene
from planner.models.shapes import Box, Carried, Mesh, Obstacle
from planner.problem.conditions import AND


def write_scene(scene: Scene, path: StrPath) -> list[Path]:
    """Write ``scene`` to ``path``, and every mesh as an OBJ file beside it; returns what was written.

    :meth:`Scene.load` reads the same scene from it, to rounding. Permissions are written shape by shape.
    Raises :class:`FileError` where that cannot be done, :class:`SceneError` for what such a file has no words for: an
    object that is placed in a frame of its own, a mesh with a radius.
    """
    path = Path(path)
    for item in (*scene.obstacles, *scene.carried):
        if item.frame:
            raise SceneError(
                f"'{item.name}' is placed in frame '{item.frame}', which no scene file says: place it in the world."
            )
    for item in (*scene.obstacles, *scene.moving, *scene.carried):
        if isinstance(item.shape, Mesh) and item.shape.radius:
            raise SceneError(f"the mesh of '{item.name}' has a radius, which no scene file says: leave that out.")
    make_folder(path.parent)
    meshes: dict[Path, Mesh] = {}
    text = "\n".join(_lines(scene, path, meshes)) + "\n"
    for file, mesh in meshes.items():
        write_whole(file, _obj(mesh).encode())
    write_whole(path, text.encode())
    return [path, *meshes]


def _lines(scene: Scene, path: Path, meshes: dict[Path, Mesh]) -> Iterator[str]:
    yield f"name: {_quoted(scene.name)}"
    if scene.description:
        yield f"description: {_quoted(scene.description)}"
    numbers = itertools.count()
    for key, things in (("obstacles", (*scene.obstacles, *scene.moving)), ("carried", scene.carried)):
        yield from _block(key, [_thing(item, path, meshes, numbers) for item in things])
    states = {robot: dict(named) for robot, named in scene.states.items()}
    if states:
        yield f"states: {_quoted(states)}"
    if scene.robots:
        placed = {name: item.model_dump(exclude_defaults=True) for name, item in scene.robots.items()}
        yield f"robots: {_quoted(placed)}"
    yield from _block("allowed", sorted(_permissions(scene)))
    yield from _block("keep", scene.keep.split(AND) if scene.keep else [])


def _block(key: str, items: list[Any]) -> Iterator[str]:
    if items:
        yield f"{key}:"
        yield from (f"  - {_quoted(item)}" for item in items)


def _quoted(data: Any) -> str:
    """``data`` as JSON that is YAML too: what JSON writes as two escapes is one there."""
    return re.sub(r"\\u(d[89ab]..)\\u(d[c-f]..)", _as_one, json.dumps(data))


def _as_one(pair: re.Match[str]) -> str:
    high, low = (int(digits, 16) & 0x3FF for digits in pair.groups())
    return f"\\U{0x10000 + (high << 10) + low:08x}"


def _thing(
    item: Obstacle | MovingObstacle | Carried, path: Path, meshes: dict[Path, Mesh], numbers: Iterator[int]
) -> dict[str, Any]:
    shape = item.shape
    data: dict[str, Any] = {"name": item.name, "type": type(shape).__name__.lower()}
    if isinstance(shape, Mesh):
        file = path.with_name(f"{path.stem}-{next(numbers)}.obj")
        meshes[file] = shape
        data["file"] = file.name
    elif isinstance(shape, Box):
        data["size"] = [float(side) for side in shape.size]
    else:
        data |= {key: float(value) for key, value in vars(shape).items()}
    match item:
        case MovingObstacle(motion=motion):
            poses = zip(motion.times, motion.poses, strict=True)
            return {**data, "motion": [{"t": float(t), **_pose(placement)} for t, placement in poses]}
        case Carried():
            return {**data, **_pose(item.placement), "link": item.link, "touch_links": list(item.touch_links)}
    limit = {"speed_limit": item.speed_limit} if item.speed_limit > 0 else {}
    return {**data, **_pose(item.placement), **limit}


def _pose(placement: Floats) -> dict[str, Any]:
    return {"position": placement[:3, 3].tolist(), "quaternion": quaternion_of(placement[:3, :3])}


def _permissions(scene: Scene) -> Iterator[list[str]]:
    """Pairs of names that may touch, where a name is that of a shape or a link."""
    shapes: dict[str, list[str]] = {}
    for item in (*scene.obstacles, *scene.carried):
        shapes.setdefault(item.object, []).append(item.name)
    for pair in scene.allowed:
        first, second = (tuple(pair) * 2)[:2]
        for a, b in itertools.product(shapes.get(first, [first]), shapes.get(second, [second])):
            yield sorted((a, b))


def _obj(mesh: Mesh) -> str:
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
    return vertices + "".join(f"f {i + 1} {j + 1} {k + 1}\n" for i, j, k in mesh.triangles.tolist())
