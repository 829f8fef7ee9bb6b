"""PlanningScene messages: matrix, world, the scene, and what we take from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen
from planner.base.errors import SceneError
from planner.base.notes import Note
from planner.base.yamlfile import Name, Number, Strict, repeated, validate
from planner.models.files.moveit.fields import Label, Noted, Refused, none, notes_of
from planner.models.files.moveit.messages import (
    CollisionObject,
    Header,
    PoseMessage,
    RobotState,
    Tag,
    Text,
    TransformStamped,
    fits,
)
from planner.models.files.moveit.objects import carried, obstacles, require_once
from planner.models.shapes import Carried, Obstacle


def _row(value: Any) -> Any:
    """ROS writes a row as {enabled: [...]} or, through some exporters, as the list itself."""
    return value["enabled"] if isinstance(value, dict) and set(value) == {"enabled"} else value


class AllowedCollisionMatrix(Strict):
    entry_names: list[Name] = none()
    entry_values: list[Annotated[list[bool], pydantic.BeforeValidator(_row)]] = none()
    default_entry_names: list[Name] = none()
    default_entry_values: Annotated[
        list[bool], Refused("allows contacts of whole links or objects: allow pairs, in entry_names and entry_values")
    ] = none()

    @pydantic.model_validator(mode="after")
    def _square(self) -> AllowedCollisionMatrix:
        fits(self.entry_names, self.entry_values, "entry_values", "entry_names")
        if twice := repeated(self.entry_names):
            raise ValueError(f"'{twice[0]}' is named twice; name each once")
        fits(self.default_entry_names, self.default_entry_values, "default_entry_values", "default_entry_names")
        for name, row in zip(self.entry_names, self.entry_values, strict=True):
            if len(row) != len(self.entry_names):
                raise ValueError(
                    f"the row of '{name}' has {len(row)} values for {len(self.entry_names)} names; give one each"
                )
        values = np.array(self.entry_values, dtype=bool).reshape(2 * (len(self.entry_names),))
        uneven = np.argwhere(values != values.T)
        if len(uneven):
            first, second = (self.entry_names[k] for k in uneven[0])
            raise ValueError(f"it allows '{first}' and '{second}' in one order only; make it symmetric")
        return self

    def pairs(self, allowed: bool) -> frozenset[frozenset[str]]:
        """The pairs of names that may touch, or that the matrix says may not."""
        return frozenset(
            frozenset((first, second))
            for first, row in zip(self.entry_names, self.entry_values, strict=True)
            for second, value in zip(self.entry_names, row, strict=True)
            if value == allowed and first != second
        )


class LinkPadding(Strict):
    link_name: Text = ""
    padding: Number = 0.0


class LinkScale(Strict):
    link_name: Text = ""
    scale: Number = 1.0


class ObjectColor(Strict):
    id: Tag = ""
    color: Tag = None


class Octomap(Strict):
    header: Annotated[Header, Label] = Header()
    binary: Tag = False
    id: Tag = ""
    resolution: Tag = 0.0
    data: list[Any] | str = none()


class OctomapWithPose(Strict):
    header: Annotated[Header, Label] = Header()
    origin: Annotated[PoseMessage, Label] = PoseMessage()
    octomap: Octomap = Octomap()


class PlanningSceneWorld(Strict):
    collision_objects: list[CollisionObject] = none()
    octomap: Annotated[
        OctomapWithPose,
        Refused(
            "is not read, so what it holds would not be seen: give boxes or meshes in its place",
            when=lambda value: bool(value.octomap.data),
        ),
    ] = OctomapWithPose()


class PlanningSceneMessage(Strict):
    name: Name = ""
    robot_state: RobotState = RobotState()
    robot_model_name: Name = ""
    fixed_frame_transforms: list[TransformStamped] = none()
    allowed_collision_matrix: AllowedCollisionMatrix = AllowedCollisionMatrix()
    link_padding: Annotated[
        list[LinkPadding], Refused("is not 0: keep a distance from everything with --margin in its place")
    ] = none()
    link_scale: Annotated[
        list[LinkScale],
        Refused(
            "is not 1: keep a distance from everything with --margin in its place",
            when=lambda value: any(each.scale != 1.0 for each in value),
        ),
    ] = none()
    object_colors: Annotated[list[ObjectColor], Label] = none()
    world: PlanningSceneWorld = PlanningSceneWorld()
    is_diff: Annotated[
        bool, Noted("it is a difference to a scene that is not here, and is taken for the whole", grave=True)
    ] = False


@dataclass(frozen=True)
class PlanningScene:
    """What a message says: obstacles, carried shapes, allowed pairs by name, and what only a robot can make sense of.

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
    message = validate(PlanningSceneMessage, data, where, SceneError)
    objects, held = message.world.collision_objects, message.robot_state.attached_collision_objects
    require_once([*(item.id for item in objects), *(item.object.id for item in held)], where)
    return PlanningScene(
        message.name or path.stem,
        message.robot_model_name,
        tuple(shape for item in objects for shape in obstacles(item, where)),
        carried(held, where),
        message.allowed_collision_matrix.pairs(True),
        message.allowed_collision_matrix.pairs(False),
        _frames(message.fixed_frame_transforms, where),
        message.robot_state.joint_state.values(),
        notes_of(message, where),
    )


def _frames(transforms: list[TransformStamped], where: str) -> dict[str, tuple[str, Floats]]:
    """The frames that the message places, each with the frame that it is placed in."""
    placed = {
        each.child_frame_id.removeprefix("/"): (each.header.frame_id.removeprefix("/"), frozen(each.transform.matrix()))
        for each in transforms
    }
    wrong = next((name for name, (parent, _) in placed.items() if parent in placed), None)
    if wrong is not None or len(placed) < len(transforms):
        raise SceneError(
            f"{where}: fixed_frame_transforms place a frame twice, or in one another; give each once, in the planning "
            "frame."
        )
    return placed
