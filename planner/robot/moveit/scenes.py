"""PlanningScene messages, and MoveIt's ``.scene`` text, as obstacles and permissions."""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import Note, SceneError
from planner.base.yamlfile import find_duplicates, number, quote
from planner.robot.files.clouds import OCTOMAP, decode_octomap
from planner.robot.moveit.messages import (
    AttachedCollisionObject,
    CollisionObject,
    OctomapWithPose,
    PlanningSceneMessage,
    SolidPrimitive,
    TransformStamped,
    read_message,
)
from planner.robot.shapes import Box, Carried, Cylinder, Mesh, Obstacle, Shape, Sphere


@dataclass(frozen=True)
class PlanningScene:
    """Obstacles, carried shapes, allowed pairs, and content that only a robot gives a meaning.

    ``frames`` are placed (4, 4) in a parent frame, empty for the scene's own; ``robot`` is the model's name; ``state``
    has joint values by name; ``checked`` are pairs that may not touch.
    """

    name: str
    robot: str
    obstacles: tuple[Obstacle, ...]
    carried: tuple[Carried, ...] = ()
    allowed: frozenset[frozenset[str]] = frozenset()
    checked: frozenset[frozenset[str]] = frozenset()
    frames: Mapping[str, tuple[str, Floats]] = field(default_factory=dict)
    state: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()


def parse_planning_scene(data: Any, path: Path) -> PlanningScene:
    """Return a PlanningScene from plain data; :class:`SceneError` names the wrong object or field."""
    where = f"MoveIt scene {path}"
    message, notes = read_message(PlanningSceneMessage, data, where)
    if message.is_diff:
        notes += (Note(f"{where}: it is a difference (is_diff) to an unknown scene; it counts as a complete scene."),)
    objects, held = message.world.collision_objects, message.robot_state.attached_collision_objects
    _require_distinct([*objects, *(item.object for item in held)], where)
    return PlanningScene(
        message.name or path.stem,
        message.robot_model_name,
        (*(shape for item in objects for shape in _obstacles(item, where)), *_octomap(message.world.octomap, where)),
        read_attached(held, where),
        message.allowed_collision_matrix.pairs(True),
        message.allowed_collision_matrix.pairs(False),
        _frames(message.fixed_frame_transforms, where),
        message.robot_state.joint_state.values(),
        notes,
    )


def parse_scene_text(text: str, path: Path) -> PlanningScene:
    """Return MoveIt's ``.scene`` text, with or without object poses."""
    lines = deque(line.strip() for line in text.splitlines() if line.strip())
    try:
        name = lines.popleft().strip("()")[:1000]
        objects = list(_objects(lines))
    except IndexError:
        raise SceneError(f"MoveIt scene {path} ends before its closing dot; export it again.") from None
    except ValueError as error:
        raise SceneError(f"MoveIt scene {path}: {quote(str(error))[1:-1]}; export it again.") from None
    return parse_planning_scene({"name": name, "world": {"collision_objects": objects}}, path)


def _objects(lines: deque[str]) -> Iterator[dict[str, Any]]:
    """Yield every object of a ``.scene`` text as a message; ValueError, or IndexError at its end."""
    while (line := lines.popleft()) != ".":
        if not line.startswith("*"):
            raise ValueError(f"expected '* name' of an object, got {line}")
        item: dict[str, Any] = {"id": line[1:].strip(), "primitives": [], "primitive_poses": []}
        if len(lines[0].split()) == 3:  # newer files place the object first
            item["pose"] = _pose(lines)
        for _ in range(_count(lines)):
            kind = lines.popleft()
            size = _numbers(lines)[:: -1 if kind == "cylinder" else 1]  # a message has the height before the radius
            item["primitives"].append({"type": kind, "dimensions": size})
            item["primitive_poses"].append(_pose(lines))
            lines.popleft()  # colour
        if lines[0].isdecimal():
            item["subframe_names"] = [(lines.popleft(), _pose(lines))[0] for _ in range(_count(lines))]
        yield item
    if lines:
        raise ValueError(f"expected nothing after the closing dot, got {lines[0]}")


def _pose(lines: deque[str]) -> dict[str, Any]:
    return {"position": _numbers(lines), "orientation": _numbers(lines)}


def _count(lines: deque[str]) -> int:
    line = lines.popleft()
    if not line.isdecimal() or number(line) > len(lines):
        raise ValueError(f"expected a count, got {line}")
    return int(line)


def _numbers(lines: deque[str]) -> list[float]:
    return [number(part) for part in lines.popleft().split()]


def _frames(transforms: Sequence[TransformStamped], where: str) -> dict[str, tuple[str, Floats]]:
    """Return the frames that the message places, each with its parent frame."""
    placed = {each.child_frame_id: (each.header.frame_id, each.transform.matrix()) for each in transforms}
    if len(placed) < len(transforms) or any(parent in placed for parent, _ in placed.values()):
        text = "fixed_frame_transforms place a frame twice, or in one another; give each once, in the planning frame"
        raise SceneError(f"{where}: {text}.")
    return placed


def _require_distinct(items: Sequence[CollisionObject], where: str) -> None:
    """Raise :class:`SceneError` for two objects of one name, of which MoveIt would keep the last."""
    if twice := find_duplicates(item.id for item in items):
        raise SceneError(f"{where}: object {quote(twice[0])} is given twice; rename one, or take it out.")


def read_attached(items: Sequence[AttachedCollisionObject], where: str) -> tuple[Carried, ...]:
    """Return the shapes of attached objects, each in the frame of its header, or else of its link."""
    _require_distinct([item.object for item in items], where)
    return tuple(
        Carried(
            item.link_name, each.name, each.shape, each.placement, item.touch_links, each.frame, 0.0, each.object_id
        )
        for item in items
        for each in _obstacles(item.object, where)
    )


def _obstacles(item: CollisionObject, where: str) -> Iterator[Obstacle]:
    """Yield each shape as an obstacle in the frame of its header, numbered if there are several."""
    where = f"{where}: object {quote(item.id)}"
    for shapes, poses in ((item.primitives, item.primitive_poses), (item.meshes, item.mesh_poses)):
        if len(shapes) != len(poses):
            raise SceneError(f"{where} has {len(shapes)} shapes and {len(poses)} poses; give one pose a shape.")
    try:
        meshes = [Mesh(np.array(each.vertices), np.array(each.triangles)) for each in item.meshes]
    except SceneError as error:
        raise SceneError(f"{where}: {error}") from None
    shapes = [*(_solid(each, where) for each in item.primitives), *meshes]
    if not shapes:
        raise SceneError(f"{where} has no shape; give it primitives or meshes, or take it out.")
    for k, (shape, placement) in enumerate(zip(shapes, [*item.primitive_poses, *item.mesh_poses], strict=True)):
        name = item.id if len(shapes) == 1 else f"{item.id}.{k}"
        yield Obstacle(name, shape, item.pose.matrix() @ placement.matrix(), item.id, frame=item.header.frame_id)


def _octomap(message: OctomapWithPose, where: str) -> Iterator[Obstacle]:
    """The solid cells of an octomap under the name that MoveIt's matrices have for it."""
    tree = message.octomap
    if not tree.data:
        return
    try:
        content = bytes(byte % 256 for byte in tree.data)
        voxels = decode_octomap(content, tree.resolution, tree.binary, tree.id)
    except ValueError as error:
        raise SceneError(f"{where}: world.octomap cannot be read ({error}); export it again.") from None
    if voxels is not None:
        yield Obstacle(OCTOMAP, voxels, message.origin.matrix(), frame=message.header.frame_id)


def _solid(primitive: SolidPrimitive, where: str) -> Shape:
    match primitive.kind, primitive.dimensions:
        case "box", [x, y, z]:
            return Box((x, y, z))
        case "sphere", [radius]:
            return Sphere(radius)
        case "cylinder", [height, radius]:
            return Cylinder(radius, height)
    raise SceneError(
        f"{where}: a primitive of type '{primitive.kind}' with {len(primitive.dimensions)} dimensions is not "
        "supported; use box [x, y, z], sphere [radius] or cylinder [height, radius]."
    )
