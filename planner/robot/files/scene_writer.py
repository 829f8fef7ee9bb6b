"""A scene as a file of our own format, with its meshes beside it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from planner.base.arrays import Floats
from planner.base.errors import SceneError
from planner.base.files import StrPath, make_folder, write_whole
from planner.base.yamlfile import yaml_text
from planner.problem.conditions import AND
from planner.robot.moving import MovingObstacle
from planner.robot.poses import quaternion_of
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Mesh, Obstacle


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
    meshes: dict[Path, Mesh] = {}
    for item in (*scene.obstacles, *scene.moving, *scene.carried):
        if isinstance(item.shape, Mesh):
            meshes[path.with_name(f"{path.stem}-{len(meshes)}.obj")] = item.shape
            if item.shape.radius:
                raise SceneError(f"the mesh of '{item.name}' has a radius, which no scene file says: leave that out.")
    files = iter(meshes)
    content = {
        "name": scene.name,
        "description": scene.description,
        "obstacles": [_thing(item, files) for item in (*scene.obstacles, *scene.moving)],
        "carried": [_thing(item, files) for item in scene.carried],
        "states": {robot: dict(named) for robot, named in scene.states.items()},
        "robots": {name: item.model_dump(exclude_defaults=True) for name, item in scene.robots.items()},
        "allowed": sorted(_permissions(scene)),
        "keep": scene.keep.split(AND) if scene.keep else [],
    }
    text = yaml_text({key: value for key, value in content.items() if value or key == "name"})
    make_folder(path.parent)
    for file, mesh in meshes.items():
        write_whole(file, _obj(mesh).encode())
    write_whole(path, text.encode())
    return [path, *meshes]


def _thing(item: Obstacle | MovingObstacle | Carried, files: Iterator[Path]) -> dict[str, Any]:
    """A thing under the keys of a scene file; a mesh is in the next of the ``files``."""
    shape = {"file": next(files).name} if isinstance(item.shape, Mesh) else vars(item.shape)
    data = {"name": item.name, "type": type(item.shape).__name__.lower(), **shape}
    match item:
        case MovingObstacle(motion=motion):
            poses = zip(motion.times.tolist(), motion.poses, strict=True)
            return {**data, "motion": [{"t": t, **_pose(placement)} for t, placement in poses]}
        case Carried():
            return {**data, **_pose(item.placement), "link": item.link, "touch_links": list(item.touch_links)}
    limit = {"speed_limit": float(item.speed_limit)} if item.speed_limit > 0 else {}
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
