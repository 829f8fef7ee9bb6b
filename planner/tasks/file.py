"""A task as people write it: what is picked, where it is placed, where the arm goes; YAML, or these classes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pydantic

from planner.base.arrays import Floats, as_frozen, numbers, placement
from planner.base.errors import SceneError
from planner.base.files import is_file
from planner.base.kinds import checks_kinds
from planner.base.places import Place as FilePlace
from planner.base.places import place as file_place
from planner.base.resources import scene_file
from planner.base.yamlfile import FARTHEST, Coordinate, Name, Number, Size, Strict, parse_yaml, read_text, validate
from planner.models.poses import pose
from planner.models.scene import PoseFile, Triple
from planner.problem.request import Thing

Frame = Literal["tool", "world"]
_TURNS = 12  # of the tool about an axis that is free
_TILTS = 6  # directions in which it is tilted on the edge of a cone
_FARTHEST_LINE = 1.0  # m
MOST_SAMPLES = 1000


class TaskError(SceneError):
    """A task that makes no sense in its scene, or for its robot."""


@checks_kinds
@dataclass(frozen=True, eq=False)
class Grasp:
    """Where the tool is when it holds an object: its pose (4, 4) in the object's frame.

    ``opening`` (m) is how wide the gripper is then, None where nobody knows.
    """

    pose: Floats
    opening: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", as_frozen(placement("grasp", self.pose, TaskError, FARTHEST)))


@checks_kinds
@dataclass(frozen=True)
class Line:
    """A straight motion of the tool by ``distance`` (m) along ``axis`` of its own ``frame`` at rest, or the world's."""

    distance: float
    axis: tuple[float, float, float]
    frame: Frame = "tool"

    def __post_init__(self) -> None:
        axis = numbers("axis", self.axis, (3,), TaskError, FARTHEST)
        length = float(np.linalg.norm(axis))
        if not (0.0 <= self.distance <= _FARTHEST_LINE and length > 1e-9):
            raise TaskError(
                f"a line of {self.distance:g} m along {list(self.axis)} is not usable: give metres from 0 to "
                f"{_FARTHEST_LINE:g}, and an axis that is not zero."
            )
        object.__setattr__(self, "axis", tuple((axis / length).tolist()))


@checks_kinds
@dataclass(frozen=True, eq=False)
class Pick:
    """Take ``object``: go to it along the line ``approach``, close the gripper, leave along ``retreat``.

    ``grasps`` None: they are generated from its shape, see :mod:`planner.tasks.grasps`.
    """

    object: str
    grasps: tuple[Grasp, ...] | None = None
    approach: Line = Line(0.1, (0.0, 0.0, 1.0))
    retreat: Line = Line(0.1, (0.0, 0.0, 1.0), "world")


@checks_kinds
@dataclass(frozen=True)
class Region:
    """On the top of the box ``on``, between corners (x, y) of the world, m: ``samples`` placements in it, standing.

    The object stands as it stood in the scene, turned about the vertical.
    """

    on: str
    corners: tuple[tuple[float, float], tuple[float, float]]
    samples: int = 20


@checks_kinds
@dataclass(frozen=True, eq=False)
class Place:
    """Put ``object`` down in one of the poses (4, 4) ``at``, or in a region: there along ``approach``, off ``retreat``.

    The tool's frame is that of the hand as it holds the object.
    """

    object: str
    at: Region | tuple[Floats, ...]
    approach: Line = Line(0.1, (0.0, 0.0, -1.0), "world")
    retreat: Line = Line(0.1, (0.0, 0.0, -1.0))


@checks_kinds
@dataclass(frozen=True)
class Move:
    """Go to a state: a name, ``q:...``, ``xyz:...`` or ``pose:...``, as ``planner plan`` reads it."""

    to: str


Step = Pick | Place | Move


@checks_kinds
@dataclass(frozen=True)
class GripperSaid:
    """What a task says of the gripper: joint values ``open`` and ``closed``, its widest ``opening`` (m), links.

    ``touch`` are links that may touch what is grasped. What is left out is taken from the robot, where it is known.
    """

    open: Mapping[str, float] | None = None
    closed: Mapping[str, float] | None = None
    opening: float | None = None
    touch: tuple[str, ...] | None = None


@checks_kinds
@dataclass(frozen=True, eq=False)
class Task:
    """Steps of one arm in one scene, in this order; what is picked are obstacles of the scene, by name.

    Task.load("task.yaml")
    Task("panda", "table.yaml", (Pick("mug"), Place("mug", Region("board", ((0.4, 0.1), (0.7, 0.3)))), Move("home")))
    """

    robot: Thing
    scene: Thing
    steps: tuple[Step, ...]
    start: str = "home"
    gripper: GripperSaid = field(default_factory=GripperSaid)
    name: str = "task"

    def __post_init__(self) -> None:
        if not self.steps:
            raise TaskError("a task has no steps: give at least one Pick, Place or Move.")

    @staticmethod
    def load(path: FilePlace) -> Task:
        """The task in a YAML file; :class:`TaskError` or ``FileError`` name the key that is wrong."""
        path = file_place(path, "task")
        where = f"task file {path}"
        file = validate(TaskFile, parse_yaml(read_text(path, "task file"), where), where, TaskError)
        try:
            return _task(file, path)
        except ValueError as error:
            raise TaskError(f"{where}: {error}") from None


class LineFile(Strict):
    """A line: its length, which may stand for it alone, and where it is not the usual one its axis in a frame."""

    distance: Annotated[Number, pydantic.Field(ge=0, le=_FARTHEST_LINE)] = 0.1
    axis: Triple | None = None
    frame: Frame | None = None

    @pydantic.model_validator(mode="after")
    def _of_an_axis(self) -> LineFile:
        if self.frame is not None and self.axis is None:
            raise ValueError("a frame is that of an axis: give both, or neither")
        return self


Along = Annotated[LineFile, pydantic.BeforeValidator(lambda said: {"distance": said} if _plain(said) else said)]


def _plain(said: Any) -> bool:
    return not isinstance(said, dict | LineFile)


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


class PickFile(Strict):
    pick: Name
    grasps: Annotated[
        Annotated[list[GraspFile], pydantic.Field(min_length=1)] | None,
        pydantic.BeforeValidator(lambda said: None if said == "auto" else said),
    ] = None
    approach: Along = LineFile()
    retreat: Along = LineFile()


class PlaceFile(Strict):
    place: Name
    on: Name | None = None
    at: tuple[tuple[Coordinate, Coordinate], tuple[Coordinate, Coordinate]] | None = None
    samples: Annotated[int, pydantic.Field(ge=1, le=MOST_SAMPLES)] = 20
    pose: Annotated[
        Annotated[list[PoseFile], pydantic.Field(min_length=1)] | None,
        pydantic.BeforeValidator(lambda said: [said] if isinstance(said, dict) else said),
    ] = None
    approach: Along = LineFile()
    retreat: Along = LineFile()

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


class MoveFile(Strict):
    move: Name


_KINDS = ("pick", "place", "move")


def _kind(data: Any) -> str | None:
    said = [kind for kind in _KINDS if isinstance(data, dict) and kind in data]
    return said[0] if len(said) == 1 else None


StepFile = Annotated[
    Annotated[PickFile, pydantic.Tag("pick")]
    | Annotated[PlaceFile, pydantic.Tag("place")]
    | Annotated[MoveFile, pydantic.Tag("move")],
    pydantic.Discriminator(_kind, custom_error_type="step", custom_error_message="give one of pick, place and move"),
]


class GripperFile(Strict):
    open: dict[str, Coordinate] | None = None
    closed: dict[str, Coordinate] | None = None
    opening: Size | None = None
    touch: list[Name] | None = None


class TaskFile(Strict):
    """What a task file holds."""

    robot: Name
    scene: Name
    start: Name = "home"
    gripper: GripperFile = GripperFile()
    steps: Annotated[list[StepFile], pydantic.Field(min_length=1)]


def _task(file: TaskFile, path: Path) -> Task:
    said = file.gripper
    gripper = GripperSaid(said.open, said.closed, said.opening, None if said.touch is None else tuple(said.touch))
    steps = tuple(map(_step, file.steps))
    return Task(_beside(file.robot, path), _beside(file.scene, path), steps, file.start, gripper, path.stem)


def _beside(name: str, path: Path) -> str:
    """A file beside the task file, where there is one of that name and the planner has none built in."""
    near = path.parent / name
    return str(near) if scene_file(name) is None and is_file(near) else name


def _step(file: PickFile | PlaceFile | MoveFile) -> Step:
    match file:
        case PickFile():
            grasps = None if file.grasps is None else tuple(g for one in file.grasps for g in _grasps(one))
            plain = Pick(file.pick, grasps)
        case PlaceFile():
            if file.on is not None and file.at is not None:
                at: Region | tuple[Floats, ...] = Region(file.on, file.at, file.samples)
            else:
                at = tuple(each.matrix() for each in file.pose or ())
            plain = Place(file.place, at)
        case MoveFile():
            return Move(file.move)
    lines = {name: _line(getattr(file, name), getattr(plain, name)) for name in ("approach", "retreat")}
    return replace(plain, **lines)


def _line(said: LineFile, plain: Line) -> Line:
    if said.axis is None:
        return replace(plain, distance=said.distance)
    return Line(said.distance, said.axis, said.frame or "tool")


def _grasps(file: GraspFile) -> Iterator[Grasp]:
    """The grasp, or where an axis leaves the tool free some of all that it allows, evenly."""
    if file.axis is None:
        yield Grasp(file.matrix(), file.opening)
        return
    axis = np.array(file.axis) / np.linalg.norm(file.axis)
    across = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    side = across / np.linalg.norm(across)
    directions = [axis]
    if file.cone:
        around = np.arange(_TILTS) * 2 * np.pi / _TILTS
        edge = np.outer(np.cos(around), side) + np.outer(np.sin(around), np.cross(axis, side))
        directions += list(np.cos(file.cone) * axis + np.sin(file.cone) * edge)
    for direction in directions:
        yield from turned_about(np.array(file.position), direction, file.opening, _TURNS)


def turned_about(position: Floats, direction: Floats, opening: float | None, turns: int) -> Iterator[Grasp]:
    """Grasps at ``position`` with the tool's z along a unit ``direction``, turned about it by even steps."""
    across = np.cross(direction, np.eye(3)[int(np.abs(direction).argmin())])
    side = across / np.linalg.norm(across)
    for angle in np.arange(turns) * 2 * np.pi / turns:
        closing = np.cos(angle) * side + np.sin(angle) * np.cross(direction, side)
        yield Grasp(tool_at(position, direction, closing), opening)


def tool_at(position: Floats, approach: Floats, closing: Floats) -> Floats:
    """The pose (4, 4) of a tool whose z is along ``approach`` and whose y along ``closing``, unit and orthogonal."""
    matrix = np.array(pose(position.tolist()))
    matrix[:3, :3] = np.column_stack([np.cross(closing, approach), closing, approach])
    return matrix
