"""PlanningScene messages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from planner.base.arrays import Floats, frozen
from planner.base.errors import SceneError
from planner.base.notes import Note
from planner.base.yamlfile import validate
from planner.world.moveit.fields import notes_of
from planner.world.moveit.messages import PlanningSceneMessage, TransformStamped
from planner.world.moveit.objects import carried, obstacles, require_once
from planner.world.shapes import Carried, Obstacle


@dataclass(frozen=True)
class PlanningScene:
    """What a message says: obstacles, carried shapes, allowed pairs by name, and what only a robot can make sense of.

    ``frames`` are placed (4, 4) in another frame each, empty for the scene's own; ``robot`` is the model that it was
    made for; ``state`` holds joint values by name.
    """

    name: str
    robot: str
    obstacles: tuple[Obstacle, ...]
    carried: tuple[Carried, ...] = ()
    allowed: frozenset[frozenset[str]] = frozenset()
    frames: Mapping[str, tuple[str, Floats]] = field(default_factory=dict)
    state: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()


def planning_scene(data: Any, path: Path) -> PlanningScene:
    """A PlanningScene message out of plain data; :class:`SceneError` names the object or field that is wrong."""
    where = f"MoveIt scene {path}"
    message = validate(PlanningSceneMessage, data, where, SceneError)
    objects = message.world.collision_objects
    require_once([item.id for item in objects], where)
    return PlanningScene(
        message.name or path.stem,
        message.robot_model_name,
        tuple(shape for item in objects for shape in obstacles(item, where)),
        carried(message.robot_state.attached_collision_objects, where),
        message.allowed_collision_matrix.allowed(),
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
