"""A task: its steps pick, place and move. The classes are also the format of task files."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Discriminator, Field, GetPydanticSchema, Tag, model_validator
from pydantic_core import core_schema

from planner.base.arrays import Floats, frozen, numbers, placement
from planner.base.errors import SceneError
from planner.base.files import StrPath
from planner.base.resources import scene_file
from planner.base.yamlfile import FARTHEST, Coordinate, Name, Number, Size, Whole, parse_yaml, read_text, validate
from planner.problem.options import RobotLike
from planner.problem.targets import read_target
from planner.robot.poses import quaternion_of
from planner.robot.scene import PoseFile, Triple

_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)


class TaskError(SceneError, ValueError):
    """An infeasible task for its scene or robot."""


@dataclass(frozen=True)
class Line:
    """A straight motion of the tool by ``distance`` (m) along ``axis`` in the ``frame`` of tool or world.

    The default axis depends on the step: the tool's z to a grasp and upwards off it, downwards to a placement and
    against the tool's z off it. In a file, a number is a distance.
    """

    distance: Annotated[Number, Field(ge=0, le=1)] = 0.1
    axis: Triple | None = None
    frame: Literal["tool", "world"] = "tool"
    __pydantic_config__: ClassVar = _STRICT

    def __post_init__(self) -> None:
        if self.axis is not None:
            axis = numbers("axis", self.axis, (3,), TaskError, FARTHEST)
            length = float(np.linalg.norm(axis))
            if not length > 1e-9:
                raise TaskError("axis must have a length above 0, got 0: give another, or none.")
            object.__setattr__(self, "axis", tuple((axis / length).tolist()))

    def or_along(self, axis: Triple, frame: Literal["tool", "world"]) -> Line:
        """Return the line, with ``axis`` if it has none."""
        return replace(self, axis=axis, frame=frame) if self.axis is None else self


Along = Annotated[Line, BeforeValidator(lambda given: given if isinstance(given, dict) else {"distance": given})]


class Grasp(PoseFile):
    """The tool's pose in the frame of the held object, and the ``opening`` (m) of the gripper.

    With an ``axis``, the tool's z is within a ``cone`` (rad) about it, and the tool is free to turn.
    """

    axis: Triple | None = None
    cone: Annotated[Number, Field(ge=0, le=1.5)] = 0.0
    opening: Annotated[Size, Field(le=1)] | None = None

    @model_validator(mode="after")
    def _has_one_direction(self) -> Grasp:
        turned = self.rpy is not None or self.quaternion is not None
        if self.axis is not None and (turned or not np.linalg.norm(self.axis) > 1e-9):
            raise ValueError("axis must be nonzero and without quaternion or rpy: give one of them")
        if self.axis is None and self.cone:
            raise ValueError("cone needs an axis: give one")
        return self

    @staticmethod
    def from_matrix(tool: Floats, opening: float | None = None) -> Grasp:
        """Return the grasp with the tool at ``tool`` (4, 4) in the object's frame."""
        tool = placement("tool", tool, TaskError)
        x, y, z, *turn = [*tool[:3, 3].tolist(), *quaternion_of(tool[:3, :3])]
        return Grasp(position=(x, y, z), quaternion=(turn[0], turn[1], turn[2], turn[3]), opening=opening)


@dataclass(frozen=True, eq=False)
class Pick:
    """Pick ``object``: approach along the line ``approach``, close the gripper, leave along ``retreat``.

    ``grasps`` None generates them from the shape, see :mod:`planner.tasks.sampling`.
    """

    object: Annotated[Name, Field(alias="pick")]
    grasps: Annotated[
        Annotated[tuple[Grasp, ...], Field(min_length=1)] | None,
        BeforeValidator(lambda given: None if given == "auto" else given),
    ] = None
    approach: Along = Line()
    retreat: Along = Line()
    __pydantic_config__: ClassVar = _STRICT

    def __post_init__(self) -> None:
        object.__setattr__(self, "approach", self.approach.or_along((0.0, 0.0, 1.0), "tool"))
        object.__setattr__(self, "retreat", self.retreat.or_along((0.0, 0.0, 1.0), "world"))


def _read_poses(_: Any, handler: Any) -> core_schema.CoreSchema:
    """Read one pose or a list of poses as matrices."""
    listed = BeforeValidator(lambda given: [given] if isinstance(given, dict) else given)
    schema = handler(Annotated[list[PoseFile], Field(min_length=1), listed])
    return core_schema.no_info_after_validator_function(lambda poses: tuple(each.matrix() for each in poses), schema)


@dataclass(frozen=True, eq=False)
class Place:
    """Place ``object`` ``on`` a box between world corners ``at`` (x, y), or at one of the poses ``pose``.

    The planner tries ``samples`` placements in that region, with the object upright as in the scene and turned about
    the vertical. ``pose`` are placements (4, 4) of the object. The tool moves along ``approach`` to the placement and
    along ``retreat`` off it; the frame of these lines is that of the tool with the object.
    """

    object: Annotated[Name, Field(alias="place")]
    on: Name | None = None
    at: tuple[tuple[Coordinate, Coordinate], tuple[Coordinate, Coordinate]] | None = None
    samples: Annotated[Whole, Field(ge=1, le=1000)] = 20
    pose: Annotated[tuple[Floats, ...], GetPydanticSchema(_read_poses)] = ()
    approach: Along = Line()
    retreat: Along = Line()
    __pydantic_config__: ClassVar = _STRICT

    def __post_init__(self) -> None:
        if (self.on is None) != (self.at is None) or (self.on is None) != bool(len(self.pose)):
            raise TaskError("place needs 'on' and 'at', a box and two corners of a region, or else 'pose': give one")
        poses = tuple(frozen(placement("pose", each, TaskError, FARTHEST)) for each in self.pose)
        object.__setattr__(self, "pose", poses)
        object.__setattr__(self, "approach", self.approach.or_along((0.0, 0.0, -1.0), "world"))
        object.__setattr__(self, "retreat", self.retreat.or_along((0.0, 0.0, -1.0), "tool"))


@dataclass(frozen=True)
class Move:
    """Move to a state, in the notation of the start of :func:`planner.plan`."""

    to: Annotated[Name, Field(alias="move")]
    __pydantic_config__: ClassVar = _STRICT

    def __post_init__(self) -> None:
        object.__setattr__(self, "to", self.to if isinstance(self.to, str) else read_target(self.to, "move").text)


Step = Pick | Place | Move


def step_text(step: Step) -> str:
    """Return a step in words."""
    return f"move to {step.to}" if isinstance(step, Move) else f"{type(step).__name__.lower()} {step.object}"


@dataclass(frozen=True)
class Gripper:
    """Joint values (rad, m) ``open`` and ``closed``, the largest ``opening`` (m), and links for contact.

    ``touch`` are links that may touch the grasped object. :func:`planner.tasks.sampling.complete_gripper` fills in
    None from the robot, except an opening that the robot does not define.
    """

    open: Mapping[str, Coordinate] | None = None
    closed: Mapping[str, Coordinate] | None = None
    opening: Annotated[Number, Field(gt=0, le=1)] | None = None
    touch: tuple[Name, ...] | None = None
    __pydantic_config__: ClassVar = _STRICT

    def values(self, opening: float | None) -> dict[str, float]:
        """Return the joint values at an ``opening`` (m); None is closed."""
        share = 0.0 if opening is None or not self.opening else min(opening / self.opening, 1.0)
        wide = self.open or {}
        return {name: low + share * (wide.get(name, low) - low) for name, low in (self.closed or {}).items()}


def _kind(data: Any) -> str | None:
    kinds = [kind for kind in ("pick", "place", "move") if isinstance(data, dict) and kind in data]
    return kinds[0] if len(kinds) == 1 else None


def _name_on(data: Any) -> Any:
    """Restore the key ``on``, which YAML reads as true."""
    return {"on" if key is True else key: value for key, value in data.items()}


_ONE_KIND = Discriminator(_kind, custom_error_type="step", custom_error_message="give one of pick, place and move")
_StepInFile = Annotated[
    Annotated[Pick, Tag("pick")]
    | Annotated[Place, BeforeValidator(_name_on), Tag("place")]
    | Annotated[Move, Tag("move")],
    _ONE_KIND,
]
_NAME = GetPydanticSchema(lambda _, handler: handler(Name))


@dataclass(frozen=True, eq=False)
class Task:
    """Steps of one arm in one scene, in order; picked objects are obstacles of the scene, by name.

    Task.load("task.yaml")
    Task("panda", "table.yaml", (Pick("mug"), Place("mug", "board", ((0.4, 0.1), (0.7, 0.3))), Move("home")))
    """

    robot: Annotated[RobotLike, _NAME]
    scene: Annotated[RobotLike, _NAME]
    steps: Annotated[tuple[_StepInFile, ...], Field(min_length=1)]
    start: Name = "home"
    gripper: Gripper = Gripper()
    name: Name = "task"
    __pydantic_config__: ClassVar = _STRICT

    @staticmethod
    def load(path: StrPath) -> Task:
        """Load the task in a YAML file; :class:`TaskError` or ``FileError`` name the wrong key."""
        path = Path(path)
        where = f"task file {path}"
        data = parse_yaml(read_text(path, "task file"), where)
        task = validate(Task, {"name": path.stem, **data} if isinstance(data, dict) else data, where, TaskError)
        nearby = {name: str(path.parent / str(getattr(task, name))) for name in ("robot", "scene")}
        built_in = {name for name in nearby if scene_file(str(getattr(task, name))) is not None}
        return replace(
            task, **{name: near for name, near in nearby.items() if name not in built_in and os.path.isfile(near)}
        )
