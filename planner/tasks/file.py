"""A task as people write it: what is picked, where it is placed, where the arm goes; YAML, or these classes."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
import pydantic
from pydantic_core import core_schema

from planner.base.arrays import Floats, as_frozen, numbers, placement
from planner.base.errors import SceneError
from planner.base.files import StrPath
from planner.base.resources import scene_file
from planner.base.yamlfile import (
    FARTHEST,
    Coordinate,
    Name,
    Number,
    Size,
    Strict,
    Whole,
    parse_yaml,
    read_text,
    validate,
)
from planner.problem.options import RobotLike
from planner.robot.poses import pose
from planner.robot.scene import PoseFile, Triple

_TURNS = 12  # of the tool about an axis that is free
_TILTS = 6  # directions in which it is tilted on the edge of a cone
_FARTHEST_LINE, _WIDEST = 1.0, 1.0  # m
_MOST_SAMPLES = 1000
_STRICT = pydantic.ConfigDict(extra="forbid", allow_inf_nan=False)


class TaskError(SceneError, ValueError):
    """A task that makes no sense in its scene, or for its robot."""


@dataclass(frozen=True, eq=False)
class Grasp:
    """Where the tool is when it holds an object: its pose (4, 4) in the object's frame.

    ``opening`` (m) is how wide the gripper is then, None where nobody knows.
    """

    pose: Floats
    opening: Number | None = None

    def __post_init__(self) -> None:
        _require_positive("the opening of a grasp", self.opening)
        object.__setattr__(self, "pose", as_frozen(placement("grasp", self.pose, TaskError, FARTHEST)))


class GraspFile(PoseFile):
    """A grasp in the object's frame; with ``axis`` the tool's z is along that, within a ``cone`` (rad), and turns."""

    axis: Triple | None = None
    cone: Annotated[Number, pydantic.Field(ge=0, le=1.5)] = 0.0
    opening: Size | None = None

    @pydantic.model_validator(mode="after")
    def _one_direction(self) -> GraspFile:
        if self.axis is not None and (self.rpy is not None or self.quaternion is not None):
            raise ValueError("give a quaternion (or rpy) or an axis, not both")
        if self.axis is None and self.cone:
            raise ValueError("a cone is around an axis: give one")
        if self.axis is not None and not np.linalg.norm(self.axis) > 1e-9:
            raise ValueError("an axis of zero length has no direction")
        return self

    def grasps(self) -> Iterator[Grasp]:
        """The grasp, or where an axis leaves the tool free some of all that it allows, evenly."""
        if self.axis is None:
            yield Grasp(self.matrix(), self.opening)
            return
        axis = np.array(self.axis) / np.linalg.norm(self.axis)
        directions = [axis]
        if self.cone:
            edge = [_across(axis, angle) for angle in np.arange(_TILTS) * 2 * np.pi / _TILTS]
            directions += list(np.cos(self.cone) * axis + np.sin(self.cone) * np.array(edge))
        for direction in directions:
            yield from turned_about(np.array(self.position), direction, self.opening, _TURNS)


def turned_about(position: Floats, direction: Floats, opening: float | None, turns: int) -> Iterator[Grasp]:
    """Grasps at ``position`` with the tool's z along a unit ``direction``, turned about it by even steps."""
    for angle in np.arange(turns) * 2 * np.pi / turns:
        yield Grasp(tool_at(position, direction, _across(direction, angle)), opening)


def tool_at(position: Floats, approach: Floats, closing: Floats) -> Floats:
    """The pose (4, 4) of a tool whose z is along ``approach`` and whose y along ``closing``, unit and orthogonal."""
    matrix = np.array(pose(position.tolist()))
    matrix[:3, :3] = np.column_stack([np.cross(closing, approach), closing, approach])
    return matrix


def _across(direction: Floats, angle: float) -> Floats:
    """The unit vector at an ``angle`` (rad) around a unit ``direction``."""
    across = np.cross(direction, np.eye(3)[int(np.abs(direction).argmin())])
    side = across / np.linalg.norm(across)
    return np.cos(angle) * side + np.sin(angle) * np.cross(direction, side)


@dataclass(frozen=True)
class Line:
    """A straight motion of the tool by ``distance`` (m) along ``axis`` of its own ``frame`` at rest, or the world's.

    Without an axis it is that of the step: to a grasp along the tool's z and off it upwards, to a placement downwards
    and off it against the tool's z.
    """

    distance: Number = 0.1
    axis: Triple | None = None
    frame: Literal["tool", "world"] | None = None
    __pydantic_config__: ClassVar = _STRICT

    def __post_init__(self) -> None:
        if not 0.0 <= self.distance <= _FARTHEST_LINE:
            raise TaskError(f"a line of {self.distance:g} m is not usable: give metres from 0 to {_FARTHEST_LINE:g}.")
        if self.axis is None:
            if self.frame is not None:
                raise TaskError("a frame is that of an axis: give both, or neither.")
            return
        axis = numbers("axis", self.axis, (3,), TaskError, FARTHEST)
        length = float(np.linalg.norm(axis))
        if not length > 1e-9:
            raise TaskError("an axis of zero length has no direction: give another one, or none.")
        object.__setattr__(self, "axis", tuple((axis / length).tolist()))
        object.__setattr__(self, "frame", self.frame or "tool")

    def or_along(self, axis: Triple, frame: Literal["tool", "world"]) -> Line:
        """The line, along ``axis`` where it has none."""
        return replace(self, axis=axis, frame=frame) if self.axis is None else self


Along = Annotated[Line, pydantic.BeforeValidator(lambda said: said if isinstance(said, dict) else {"distance": said})]
_GraspFiles = Annotated[list[GraspFile], pydantic.Field(min_length=1)]


def _grasps(files: list[GraspFile] | None) -> tuple[Grasp, ...] | None:
    return None if files is None else tuple(grasp for one in files for grasp in one.grasps())


@dataclass(frozen=True, eq=False)
class Pick:
    """Take ``object``: go to it along the line ``approach``, close the gripper, leave along ``retreat``.

    ``grasps`` None: they are generated from its shape, see :mod:`planner.tasks.grasps`.
    """

    object: Annotated[Name, pydantic.Field(alias="pick")]
    grasps: Annotated[
        tuple[Grasp, ...] | None,
        pydantic.BeforeValidator(lambda said: None if said == "auto" else said),
        pydantic.GetPydanticSchema(
            lambda _, schema: core_schema.no_info_after_validator_function(_grasps, schema(_GraspFiles | None))
        ),
    ] = None
    approach: Along = Line()
    retreat: Along = Line()
    __pydantic_config__: ClassVar = _STRICT

    def __post_init__(self) -> None:
        if self.grasps is not None and not len(self.grasps):
            raise TaskError(f"no grasps of '{self.object}' are given: leave them out to have them generated.")
        object.__setattr__(self, "approach", self.approach.or_along((0.0, 0.0, 1.0), "tool"))
        object.__setattr__(self, "retreat", self.retreat.or_along((0.0, 0.0, 1.0), "world"))


@dataclass(frozen=True)
class Region:
    """On the top of the box ``on``, between corners (x, y) of the world, m: ``samples`` placements in it, standing.

    The object stands as it stood in the scene, turned about the vertical.
    """

    on: str
    corners: tuple[tuple[float, float], tuple[float, float]]
    samples: int = 20

    def __post_init__(self) -> None:
        numbers("corners", self.corners, (2, 2), TaskError, FARTHEST)
        if not 1 <= self.samples <= _MOST_SAMPLES:
            raise TaskError(f"{self.samples} samples are not usable: give a whole number from 1 to {_MOST_SAMPLES}.")


@dataclass(frozen=True, eq=False)
class Place:
    """Put ``object`` down in one of the poses (4, 4) ``at``, or in a region: there along ``approach``, off ``retreat``.

    The tool's frame is that of the hand as it holds the object.
    """

    object: str
    at: Region | tuple[Floats, ...]
    approach: Line = Line()
    retreat: Line = Line()

    def __post_init__(self) -> None:
        if not isinstance(self.at, Region):
            if not len(self.at):
                raise TaskError(f"'{self.object}' is placed nowhere: give poses, or a region.")
            poses = tuple(as_frozen(placement("pose", each, TaskError, FARTHEST)) for each in self.at)
            object.__setattr__(self, "at", poses)
        object.__setattr__(self, "approach", self.approach.or_along((0.0, 0.0, -1.0), "world"))
        object.__setattr__(self, "retreat", self.retreat.or_along((0.0, 0.0, -1.0), "tool"))


class PlaceFile(Strict):
    """A placement as a file has it: ``on`` a box in a region ``at`` of its top, or in a ``pose``."""

    place: Name
    on: Name | None = None
    at: tuple[tuple[Coordinate, Coordinate], tuple[Coordinate, Coordinate]] | None = None
    samples: Annotated[Whole, pydantic.Field(ge=1, le=_MOST_SAMPLES)] = 20
    pose: Annotated[
        Annotated[list[PoseFile], pydantic.Field(min_length=1)] | None,
        pydantic.BeforeValidator(lambda said: [said] if isinstance(said, dict) else said),
    ] = None
    approach: Along = Line()
    retreat: Along = Line()

    @pydantic.model_validator(mode="before")
    @classmethod
    def _on(cls, data: Any) -> Any:
        """YAML reads the key ``on`` as true."""
        return {"on" if key is True else key: value for key, value in data.items()} if isinstance(data, dict) else data

    @pydantic.model_validator(mode="after")
    def _one_place(self) -> PlaceFile:
        if (self.on is None) != (self.at is None):
            raise ValueError("'on' and 'at' go together: the box that it is put on, and two corners of a region")
        if (self.pose is None) == (self.on is None):
            raise ValueError("give either 'on' and 'at', or a 'pose'")
        if self.on is None and "samples" in self.model_fields_set:
            raise ValueError("'samples' are taken in a region, and poses are given: leave them out")
        return self

    def step(self) -> Place:
        """The step that it is."""
        region = self.on and self.at and Region(self.on, self.at, self.samples)
        at = region or tuple(each.matrix() for each in self.pose or ())
        return Place(self.place, at, self.approach, self.retreat)


@dataclass(frozen=True)
class Move:
    """Go to a state: a name, ``q:...``, ``xyz:...`` or ``pose:...``, as ``planner plan`` reads it."""

    to: Annotated[Name, pydantic.Field(alias="move")]
    __pydantic_config__: ClassVar = _STRICT


Step = Pick | Place | Move


@dataclass(frozen=True)
class GripperSaid:
    """What a task says of the gripper: joint values ``open`` and ``closed``, its widest ``opening`` (m), links.

    ``touch`` are links that may touch what is grasped. What is left out is taken from the robot, where it is known.
    """

    open: Mapping[str, Coordinate] | None = None
    closed: Mapping[str, Coordinate] | None = None
    opening: Number | None = None
    touch: tuple[Name, ...] | None = None
    __pydantic_config__: ClassVar = _STRICT

    def __post_init__(self) -> None:
        _require_positive("the gripper's opening", self.opening)


def _require_positive(what: str, metres: float | None) -> None:
    if metres is not None and not 0.0 < metres <= _WIDEST:
        raise TaskError(f"{what} is {metres:g} m: give metres above 0, up to {_WIDEST:g}.")


@dataclass(frozen=True, eq=False)
class Task:
    """Steps of one arm in one scene, in this order; what is picked are obstacles of the scene, by name.

    Task.load("task.yaml")
    Task("panda", "table.yaml", (Pick("mug"), Place("mug", Region("board", ((0.4, 0.1), (0.7, 0.3)))), Move("home")))
    """

    robot: RobotLike
    scene: RobotLike
    steps: tuple[Step, ...]
    start: str = "home"
    gripper: GripperSaid = field(default_factory=GripperSaid)
    name: str = "task"

    def __post_init__(self) -> None:
        if not self.steps:
            raise TaskError("a task has no steps: give at least one Pick, Place or Move.")

    @staticmethod
    def load(path: StrPath) -> Task:
        """The task in a YAML file; :class:`TaskError` or ``FileError`` name the key that is wrong."""
        path = Path(path)
        where = f"task file {path}"
        file = validate(TaskFile, parse_yaml(read_text(path, "task file"), where), where, TaskError)
        robot, scene = (_beside(name, path) for name in (file.robot, file.scene))
        steps = tuple(step.step() if isinstance(step, PlaceFile) else step for step in file.steps)
        return Task(robot, scene, steps, file.start, file.gripper, path.stem)


def _beside(name: str, path: Path) -> str:
    """A file beside the task file, where there is one of that name and the planner has none built in."""
    near = path.parent / name
    return str(near) if scene_file(name) is None and os.path.isfile(near) else name


def _kind(data: Any) -> str | None:
    said = [kind for kind in ("pick", "place", "move") if isinstance(data, dict) and kind in data]
    return said[0] if len(said) == 1 else None


class TaskFile(Strict):
    """What a task file holds."""

    robot: Name
    scene: Name
    start: Name = "home"
    gripper: GripperSaid = GripperSaid()
    steps: Annotated[
        list[
            Annotated[
                Annotated[Pick, pydantic.Tag("pick")]
                | Annotated[PlaceFile, pydantic.Tag("place")]
                | Annotated[Move, pydantic.Tag("move")],
                pydantic.Discriminator(
                    _kind, custom_error_type="step", custom_error_message="give one of pick, place and move"
                ),
            ]
        ],
        pydantic.Field(min_length=1),
    ]
