"""MoveIt's formats: PlanningScene and MotionPlanRequest messages as YAML, and ``.scene`` text files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.errors import SceneError
from planner.base.yamlfile import Coordinate, Name, Size, parse_yaml, read_text, shown, validate
from planner.world.poses import pose
from planner.world.shapes import Box, Carried, Cylinder, Mesh, Obstacle, Shape, Sphere

_TYPES = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone"}


class _Message(pydantic.BaseModel):
    """A ROS message: keys that we do not use are let pass, numbers must be finite."""

    model_config = pydantic.ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False)


_Triple = tuple[Coordinate, Coordinate, Coordinate]
_Quaternion = tuple[Coordinate, Coordinate, Coordinate, Coordinate]


def _vector(value: Any) -> Any:
    """ROS writes vectors as {x, y, z} or, through some exporters, as lists."""
    return [value[k] for k in ("x", "y", "z", "w") if k in value] if isinstance(value, dict) else value


class _Pose(_Message):
    position: _Triple = (0.0, 0.0, 0.0)
    orientation: _Quaternion = (0.0, 0.0, 0.0, 1.0)

    _lists = pydantic.field_validator("position", "orientation", mode="before")(_vector)

    @pydantic.model_validator(mode="after")
    def _turned(self) -> _Pose:
        self.matrix()  # ValueError for a quaternion of zero length
        return self

    def matrix(self) -> Floats:
        return pose(self.position, quaternion=self.orientation)


class _Primitive(_Message):
    type: Name | Annotated[int, pydantic.Field(ge=0, le=255)]  # a byte in the message
    dimensions: list[Size]

    def shape(self, where: str) -> Shape:
        """The primitive as one of our shapes; SceneError, beginning with ``where``, for one that we do not have."""
        kind = _TYPES.get(self.type, str(self.type)) if isinstance(self.type, int) else self.type
        match kind.lower(), self.dimensions:
            case "box", [x, y, z]:
                return Box((x, y, z))
            case "sphere", [radius]:
                return Sphere(radius)
            case "cylinder", [height, radius]:
                return Cylinder(radius, height)
        raise SceneError(
            f"{where}: a primitive of type '{kind}' with {len(self.dimensions)} dimensions is not supported; "
            "use box [x, y, z], sphere [radius] or cylinder [height, radius]."
        )


_Index = Annotated[int, pydantic.Field(ge=0, lt=2**31)]


class _Triangle(_Message):
    vertex_indices: tuple[_Index, _Index, _Index]


class _Mesh(_Message):
    vertices: list[Annotated[_Triple, pydantic.BeforeValidator(_vector)]]
    triangles: list[_Triangle]

    def shape(self, where: str) -> Shape:
        triangles = np.array([t.vertex_indices for t in self.triangles], dtype=np.int64).reshape(-1, 3)
        if not len(triangles) or triangles.max() >= len(self.vertices):
            raise SceneError(f"{where}: its triangles do not fit its {len(self.vertices)} vertices; export it again.")
        return Mesh(np.array(self.vertices), triangles)


class _Object(_Message):
    id: Name
    pose: _Pose = _Pose()
    primitives: list[_Primitive] = pydantic.Field(default_factory=list)
    primitive_poses: list[_Pose] = pydantic.Field(default_factory=list)
    meshes: list[_Mesh] = pydantic.Field(default_factory=list)
    mesh_poses: list[_Pose] = pydantic.Field(default_factory=list)

    def obstacles(self, where: str) -> Iterator[Obstacle]:
        """Each shape as an obstacle; an object of several shapes gives them numbered names."""
        where = f"{where}: object {shown(self.id)}"
        items = [*self.primitives, *self.meshes]
        poses = [*self.primitive_poses, *self.mesh_poses]
        if len(items) != len(poses):
            raise SceneError(f"{where} has {len(items)} shapes and {len(poses)} poses; give one pose a shape.")
        for k, (item, placement) in enumerate(zip(items, poses, strict=True)):
            name = self.id if len(items) == 1 else f"{self.id}.{k}"
            yield Obstacle(name, item.shape(where), self.pose.matrix() @ placement.matrix(), self.id)


class _Attached(_Message):
    link_name: Name
    object: _Object
    touch_links: list[Name] = pydantic.Field(default_factory=list)


class _JointState(_Message):
    name: list[Name] = pydantic.Field(default_factory=list)
    position: list[Coordinate] = pydantic.Field(default_factory=list)

    def values(self) -> dict[str, float]:
        return dict(zip(self.name, self.position, strict=False))


class _RobotState(_Message):
    joint_state: _JointState = _JointState()
    attached_collision_objects: list[_Attached] = pydantic.Field(default_factory=list)


def _row(value: Any) -> Any:
    """ROS writes a row as {enabled: [...]} or, through some exporters, as the list itself."""
    return value["enabled"] if isinstance(value, dict) and "enabled" in value else value


class _Matrix(_Message):
    entry_names: list[Name] = pydantic.Field(default_factory=list)
    entry_values: list[Annotated[list[bool], pydantic.BeforeValidator(_row)]] = pydantic.Field(default_factory=list)

    def allowed(self) -> frozenset[frozenset[str]]:
        """The pairs of names that may touch."""
        return frozenset(
            frozenset((first, second))
            for first, row in zip(self.entry_names, self.entry_values, strict=False)
            for second, value in zip(self.entry_names, row, strict=False)
            if value and first != second
        )


class _World(_Message):
    collision_objects: list[_Object] = pydantic.Field(default_factory=list)


class _PlanningScene(_Message):
    name: Name = ""
    robot_model_name: Name = ""
    robot_state: _RobotState = _RobotState()
    allowed_collision_matrix: _Matrix = _Matrix()
    world: _World = _World()


@dataclass(frozen=True, eq=False)
class PlanningScene:
    """What we take from MoveIt's message: obstacles, carried shapes, allowed pairs by name."""

    name: str
    robot: str
    obstacles: tuple[Obstacle, ...]
    carried: tuple[Carried, ...] = ()
    allowed: frozenset[frozenset[str]] = frozenset()


def planning_scene(data: Any, path: Path) -> PlanningScene:
    """A PlanningScene message out of plain data; :class:`SceneError` names the object that is wrong."""
    where = f"MoveIt scene {path}"
    message = validate(_PlanningScene, data, where, SceneError)
    carried = tuple(
        Carried(item.link_name, shape.name, shape.shape, shape.placement, tuple(item.touch_links))
        for item in message.robot_state.attached_collision_objects
        for shape in item.object.obstacles(where)
    )
    return PlanningScene(
        message.name or path.stem,
        message.robot_model_name,
        tuple(obstacle for item in message.world.collision_objects for obstacle in item.obstacles(where)),
        carried,
        message.allowed_collision_matrix.allowed(),
    )


def scene_text(text: str, path: Path) -> PlanningScene:
    """MoveIt's ``.scene`` text format, with or without the object poses that newer versions write."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if not lines:
        raise SceneError(f"MoveIt scene {path} is empty; export it again.")
    reader = _SceneText(lines[1:], path)
    return PlanningScene(lines[0].strip("()")[:1000] or path.stem, "", tuple(reader.obstacles()))


class _SceneText:
    def __init__(self, lines: Sequence[str], path: Path) -> None:
        self._lines, self._at, self._where = lines, 0, f"MoveIt scene {path}"

    def obstacles(self) -> Iterator[Obstacle]:
        """Every shape of every object, up to the closing dot."""
        while self._at < len(self._lines) and self._lines[self._at] != ".":
            line = self._next()
            if not line.startswith("*"):
                raise SceneError(
                    f"{self._where}: expected '* name' of an object, found {shown(line)}; export it again."
                )
            yield from self._object(line[1:].strip())

    def _object(self, name: str) -> Iterator[Obstacle]:
        where = f"{self._where}: object {shown(name)}"
        whole = np.eye(4)
        if len(self._peek().split()) == 3:  # newer files place the object first
            whole = self._pose(where)
        count = self._count(where)
        for k in range(count):
            kind = self._next()
            size = self._shape_numbers(kind, where)
            shape = validate(_Primitive, {"type": kind, "dimensions": size}, where, SceneError).shape(where)
            placement = self._pose(where)
            self._numbers(4, where)  # colour
            yield Obstacle(name if count == 1 else f"{name}.{k}", shape, whole @ placement, name)
        if self._peek().isdecimal():  # subframes, which nothing here refers to: name, position, rotation
            subframes = self._count(where)
            self._at += 3 * subframes

    def _shape_numbers(self, kind: str, where: str) -> list[float]:
        numbers = self._numbers({"box": 3, "sphere": 1, "cylinder": 2}.get(kind, 1), where)
        return numbers[::-1] if kind == "cylinder" else numbers  # the text has radius, length

    def _pose(self, where: str) -> Floats:
        position, rotation = self._numbers(3, where), self._numbers(4, where)
        return validate(_Pose, {"position": position, "orientation": rotation}, where, SceneError).matrix()

    def _count(self, where: str) -> int:
        value = self._numbers(1, where)[0]
        if not 0 <= value <= len(self._lines) or value % 1:
            raise SceneError(f"{where}: {value:g} is no count of what follows; export it again.")
        return int(value)

    def _peek(self) -> str:
        return self._lines[self._at] if self._at < len(self._lines) else ""

    def _next(self) -> str:
        if self._at >= len(self._lines):
            raise SceneError(f"{self._where} ends in the middle of an object; export it again.")
        self._at += 1
        return self._lines[self._at - 1]

    def _numbers(self, count: int, where: str) -> list[float]:
        line = self._next()
        try:
            values = [float(part) for part in line.split()]
        except ValueError:
            values = []
        if len(values) != count or not np.isfinite(values).all():
            raise SceneError(f"{where}: expected {count} numbers, found {shown(line)}; export it again.")
        return values


class _JointConstraint(_Message):
    joint_name: Name
    position: Coordinate


class _Region(_Message):
    primitive_poses: list[_Pose] = pydantic.Field(default_factory=list)


class _PositionConstraint(_Message):
    link_name: str = ""
    constraint_region: _Region = _Region()


class _OrientationConstraint(_Message):
    link_name: str = ""
    orientation: _Quaternion

    _lists = pydantic.field_validator("orientation", mode="before")(_vector)


class _Constraints(_Message):
    joint_constraints: list[_JointConstraint] = pydantic.Field(default_factory=list)
    position_constraints: list[_PositionConstraint] = pydantic.Field(default_factory=list)
    orientation_constraints: list[_OrientationConstraint] = pydantic.Field(default_factory=list)


class _MotionPlanRequest(_Message):
    start_state: _RobotState
    goal_constraints: list[_Constraints] = pydantic.Field(min_length=1)


@dataclass(frozen=True)
class MotionPlanRequest:
    """Start and goals of a MotionPlanRequest: joint values by name, or a tool pose as target text."""

    start: dict[str, float]
    goals: tuple[dict[str, float] | str, ...]


def read_motion_plan_request(path: Path) -> MotionPlanRequest:
    """The request at ``path``; :class:`SceneError` where it says no start or a goal that we cannot read."""
    where = f"MotionPlanRequest {path}"
    message = validate(_MotionPlanRequest, parse_yaml(read_text(path, "MotionPlanRequest"), where), where, SceneError)
    start = message.start_state.joint_state.values()
    if not start:
        raise SceneError(f"{where} has no joint state to start from; add start_state.joint_state.")
    return MotionPlanRequest(start, tuple(_goal(item, where) for item in message.goal_constraints))


def _goal(item: _Constraints, where: str) -> dict[str, float] | str:
    if item.joint_constraints:
        return {constraint.joint_name: constraint.position for constraint in item.joint_constraints}
    poses = item.position_constraints[0].constraint_region.primitive_poses if item.position_constraints else []
    if not poses:
        raise SceneError(f"{where} has a goal with neither joint nor position constraints; add one of them.")
    place = ",".join(map(repr, poses[0].position))
    if not item.orientation_constraints:
        return f"xyz:{place}"
    return f"pose:{place}," + ",".join(map(repr, item.orientation_constraints[0].orientation))
