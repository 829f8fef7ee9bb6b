"""A task: what is picked, where it is placed, where the arm goes. These classes stand in a task file as they are."""

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
    """A task that makes no sense in its scene, or for its robot."""


@dataclass(frozen=True)
class Line:
    """A straight motion of the tool by ``distance`` (m) along ``axis`` of its own ``frame`` at rest, or the world's.

    Without an axis it is that of the step: to a grasp along the tool's z and off it upwards, to a placement downwards
    and off it against the tool's z. In a file a distance alone will do.
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
                raise TaskError("axis must have a length above 0, got 0: give another one, or none.")
            object.__setattr__(self, "axis", tuple((axis / length).tolist()))

    def or_along(self, axis: Triple, frame: Literal["tool", "world"]) -> Line:
        """The line, along ``axis`` where it has none."""
        return replace(self, axis=axis, frame=frame) if self.axis is None else self


Along = Annotated[Line, BeforeValidator(lambda given: given if isinstance(given, dict) else {"distance": given})]


class Grasp(PoseFile):
    """The tool's pose in the frame of the object that it holds; the gripper is ``opening`` (m) wide then.

    With an ``axis`` the tool's z is along that, within a ``cone`` (rad) around it, and free to turn.
    """

    axis: Triple | None = None
    cone: Annotated[Number, Field(ge=0, le=1.5)] = 0.0
    opening: Annotated[Size, Field(le=1)] | None = None

    @model_validator(mode="after")
    def _has_one_direction(self) -> Grasp:
        turned = self.rpy is not None or self.quaternion is not None
        if self.axis is not None and (turned or not np.linalg.norm(self.axis) > 1e-9):
            raise ValueError("give a quaternion (or rpy) or an axis that has a length, not both")
        if self.axis is None and self.cone:
            raise ValueError("a cone is around an axis: give one")
        return self

    @staticmethod
    def from_matrix(tool: Floats, opening: float | None = None) -> Grasp:
        """The grasp with the tool at ``tool`` (4, 4) in the object's frame."""
        tool = placement("tool", tool, TaskError)
        x, y, z, *turn = [*tool[:3, 3].tolist(), *quaternion_of(tool[:3, :3])]
        return Grasp(position=(x, y, z), quaternion=(turn[0], turn[1], turn[2], turn[3]), opening=opening)


@dataclass(frozen=True, eq=False)
class Pick:
    """Take ``object``: go to it along the line ``approach``, close the gripper, leave along ``retreat``.

    ``grasps`` None: they are generated from its shape, see :mod:`planner.tasks.sampling`.
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
    """One pose or a list of poses in a file, as matrices."""
    listed = BeforeValidator(lambda given: [given] if isinstance(given, dict) else given)
    schema = handler(Annotated[list[PoseFile], Field(min_length=1), listed])
    return core_schema.no_info_after_validator_function(lambda poses: tuple(each.matrix() for each in poses), schema)


@dataclass(frozen=True, eq=False)
class Place:
    """Put ``object`` down ``on`` a box, between corners ``at`` (x, y) of the world, or in one of the poses ``pose``.

    ``samples`` placements in that region are tried, the object as it stood in the scene but turned about the vertical.
    ``pose`` are placements (4, 4) of the object. The tool goes there along ``approach`` and off along ``retreat``; its
    frame is that of the hand as it holds the object.
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
            raise TaskError("give 'on' and 'at', a box and two corners of a region, or a 'pose'")
        poses = tuple(frozen(placement("pose", each, TaskError, FARTHEST)) for each in self.pose)
        object.__setattr__(self, "pose", poses)
        object.__setattr__(self, "approach", self.approach.or_along((0.0, 0.0, -1.0), "world"))
        object.__setattr__(self, "retreat", self.retreat.or_along((0.0, 0.0, -1.0), "tool"))


@dataclass(frozen=True)
class Move:
    """Go to a state, which is written as the start of :func:`planner.plan`."""

    to: Annotated[Name, Field(alias="move")]
    __pydantic_config__: ClassVar = _STRICT

    def __post_init__(self) -> None:
        object.__setattr__(self, "to", self.to if isinstance(self.to, str) else read_target(self.to, "move").text)


Step = Pick | Place | Move


def step_text(step: Step) -> str:
    """A step in words."""
    return f"move to {step.to}" if isinstance(step, Move) else f"{type(step).__name__.lower()} {step.object}"


@dataclass(frozen=True)
class Gripper:
    """Joint values (rad, m) ``open`` and ``closed``, the widest ``opening`` (m), and the links that grasp.

    ``touch`` are the links that may touch what is grasped. None: as the robot has it, see
    :func:`planner.tasks.sampling.complete_gripper`, which fills in all but an opening that the robot does not show.
    """

    open: Mapping[str, Coordinate] | None = None
    closed: Mapping[str, Coordinate] | None = None
    opening: Annotated[Number, Field(gt=0, le=1)] | None = None
    touch: tuple[Name, ...] | None = None
    __pydantic_config__: ClassVar = _STRICT

    def values(self, opening: float | None) -> dict[str, float]:
        """The joint values at an ``opening`` (m); None: wholly closed."""
        share = 0.0 if opening is None or not self.opening else min(opening / self.opening, 1.0)
        wide = self.open or {}
        return {name: low + share * (wide.get(name, low) - low) for name, low in (self.closed or {}).items()}


def _kind(data: Any) -> str | None:
    kinds = [kind for kind in ("pick", "place", "move") if isinstance(data, dict) and kind in data]
    return kinds[0] if len(kinds) == 1 else None


def _name_on(data: Any) -> Any:
    """YAML reads the key ``on`` as true."""
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
    """Steps of one arm in one scene, in this order; what is picked are obstacles of the scene, by name.

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
        """The task in a YAML file; :class:`TaskError` or ``FileError`` name the key that is wrong."""
        path = Path(path)
        where = f"task file {path}"
        data = parse_yaml(read_text(path, "task file"), where)
        task = validate(Task, {"name": path.stem, **data} if isinstance(data, dict) else data, where, TaskError)
        beside = {name: str(path.parent / str(getattr(task, name))) for name in ("robot", "scene")}
        built_in = {name for name in beside if scene_file(str(getattr(task, name))) is not None}
        return replace(
            task, **{name: near for name, near in beside.items() if name not in built_in and os.path.isfile(near)}
        )
