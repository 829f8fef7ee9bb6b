"""PlanningScene messages as obstacles, carried shapes, allowed contacts and frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen
from planner.base.errors import SceneError
from planner.base.notes import Note
from planner.base.yamlfile import Name, repeated, shown
from planner.robot.moveit.messages import (
    AttachedCollisionObject,
    CollisionObject,
    MeshMessage,
    Message,
    RobotState,
    SolidPrimitive,
    TransformStamped,
    read_message,
    require_fit,
    require_once,
)
from planner.robot.poses import pose
from planner.robot.shapes import Box, Carried, Cylinder, Mesh, Obstacle, Shape, Sphere


class AllowedCollisionMatrix(Message):
    entry_names: tuple[Name, ...] = ()
    entry_values: tuple[list[bool], ...] = ()

    @pydantic.model_validator(mode="after")
    def _square(self) -> AllowedCollisionMatrix:
        names, rows = self.entry_names, self.entry_values
        require_fit(names, rows, "entry_values", "entry_names")
        require_once(names)
        for name, row in zip(names, rows, strict=True):
            require_fit(names, row, f"values in the row of '{name}'", "names")
        values = np.array(rows, dtype=bool).reshape(2 * (len(names),))
        for first, second in np.argwhere(values != values.T):
            raise ValueError(f"it allows '{names[first]}' and '{names[second]}' in one order only; make it symmetric")
        return self

    def pairs(self, allowed: bool) -> frozenset[frozenset[str]]:
        """The pairs of names that may touch, or that the matrix says may not."""
        names = self.entry_names
        rows, columns = np.nonzero(np.array(self.entry_values, dtype=bool) == allowed) if names else ((), ())
        return frozenset(frozenset((names[i], names[j])) for i, j in zip(rows, columns, strict=True) if i != j)


class World(Message):
    collision_objects: tuple[CollisionObject, ...] = ()


class PlanningSceneMessage(Message):
    name: Name = ""
    robot_state: RobotState = RobotState()
    robot_model_name: Name = ""
    fixed_frame_transforms: tuple[TransformStamped, ...] = ()
    allowed_collision_matrix: AllowedCollisionMatrix = AllowedCollisionMatrix()
    world: World = World()
    is_diff: bool = False


@dataclass(frozen=True)
class PlanningScene:
    """Obstacles, carried shapes, allowed pairs by name, and the parts of a message that only a robot gives a meaning.

    ``frames`` are placed (4, 4) in another frame each, empty for the scene's own; ``robot`` is the model that it was
    made for; ``state`` holds joint values by name; ``checked`` are pairs of names that it says may not touch.
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


def planning_scene(data: Any, path: Path) -> PlanningScene:
    """A PlanningScene message out of plain data; :class:`SceneError` names the object or field that is wrong."""
    where = f"MoveIt scene {path}"
    message, notes = read_message(PlanningSceneMessage, data, where)
    if message.is_diff:
        notes += (Note(f"{where}: it is a difference (is_diff) to a scene that is not here; it counts as the whole."),)
    objects, held = message.world.collision_objects, message.robot_state.attached_collision_objects
    _require_distinct([*objects, *(item.object for item in held)], where)
    return PlanningScene(
        message.name or path.stem,
        message.robot_model_name,
        tuple(shape for item in objects for shape in _obstacles(item, where)),
        carried(held, where),
        message.allowed_collision_matrix.pairs(True),
        message.allowed_collision_matrix.pairs(False),
        _frames(message.fixed_frame_transforms, where),
        message.robot_state.joint_state.values(),
        notes,
    )


def _frames(transforms: Sequence[TransformStamped], where: str) -> dict[str, tuple[str, Floats]]:
    """The frames that the message places, each with the frame that it is placed in."""
    placed = {
        each.child_frame_id: (
            each.header.frame_id,
            frozen(pose(each.transform.translation, quaternion=each.transform.rotation)),
        )
        for each in transforms
    }
    if len(placed) < len(transforms) or any(parent in placed for parent, _ in placed.values()):
        raise SceneError(
            f"{where}: fixed_frame_transforms place a frame twice, or in one another; give each once, in the planning "
            "frame."
        )
    return placed


def _require_distinct(items: Sequence[CollisionObject], where: str) -> None:
    """Raise :class:`SceneError` where a message holds two objects of one name: MoveIt would keep the last only."""
    if twice := repeated(item.id for item in items):
        raise SceneError(f"{where}: object {shown(twice[0])} is given twice; rename one, or take it out.")


def carried(items: Sequence[AttachedCollisionObject], where: str) -> tuple[Carried, ...]:
    """The shapes of attached objects, each placed in the frame of its header, or in that of its link without one."""
    _require_distinct([item.object for item in items], where)
    return tuple(
        Carried(item.link_name, each.name, each.shape, each.placement, tuple(item.touch_links), each.frame, part_of=own)
        for item in items
        for each in _obstacles(item.object, where)
        for own in (each.part_of,)
    )


def _obstacles(item: CollisionObject, where: str) -> Iterator[Obstacle]:
    """Each shape as an obstacle, in the frame of its header (empty: the scene's), numbered where several."""
    where = f"{where}: object {shown(item.id)}"
    for shapes, poses in ((item.primitives, item.primitive_poses), (item.meshes, item.mesh_poses)):
        if len(shapes) != len(poses):
            raise SceneError(f"{where} has {len(shapes)} shapes and {len(poses)} poses; give one pose a shape.")
    shapes = [*(_solid(each, where) for each in item.primitives), *(_mesh(each, where) for each in item.meshes)]
    if not shapes:
        raise SceneError(f"{where} has no shape; give it primitives or meshes, or take it out.")
    for k, (shape, placement) in enumerate(zip(shapes, [*item.primitive_poses, *item.mesh_poses], strict=True)):
        name = item.id if len(shapes) == 1 else f"{item.id}.{k}"
        yield Obstacle(name, shape, item.pose.matrix() @ placement.matrix(), item.id, frame=item.header.frame_id)


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


def _mesh(mesh: MeshMessage, where: str) -> Shape:
    triangles = np.array(mesh.triangles, dtype=np.int64).reshape(-1, 3)
    if not len(triangles) or triangles.max() >= len(mesh.vertices):
        raise SceneError(f"{where}: its triangles do not fit its {len(mesh.vertices)} vertices; export it again.")
    return Mesh(np.array(mesh.vertices), triangles)
