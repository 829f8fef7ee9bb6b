"""The ROS messages that planning uses, and one rule for all other keys."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.errors import Note, SceneError, choices
from planner.base.yamlfile import (
    Coordinate,
    Name,
    Number,
    Strict,
    Whole,
    find_duplicates,
    models_in,
    suggest_name,
    validate,
)
from planner.robot.poses import pose

_AT_REST = 0.01  # rad/s, m/s: encoders report this much of an arm that stands
_SAME = 1e-9  # numbers no further from a default are that default
_LABELS = {  # names, dates and colours, which mean nothing by themselves
    "header", "stamp", "seq", "frame_id", "id", "name", "type", "link_name", "joint_names", "default_entry_names",
    "object_colors", "resolution", "binary",
}  # fmt: skip
_HARMLESS = {  # no path depends on these: a note names those with a value
    "subframe_names", "subframe_poses", "detach_posture", "weight", "effort", "wrench", "workspace_parameters",
    "reference_trajectories", "pipeline_id", "planner_id", "num_planning_attempts", "allowed_planning_time",
    "cartesian_speed_limited_link", "cartesian_speed_end_effector_link",
}  # fmt: skip
_AS_LISTS = ("xyz", "xyzw", ("enabled",), ("vertex_indices",))  # keys of messages that some exporters write as lists

Kind = TypeVar("Kind", bound="Message")


class Message(Strict):
    """Base class of messages; :func:`read_message` checks keys that a message lacks."""

    model_config = pydantic.ConfigDict(extra="ignore")


def read_message(kind: type[Kind], data: Any, where: str) -> tuple[Kind, tuple[Note, ...]]:
    """Return a message from plain data, and a note on harmless keys that are ignored.

    ROS default values (0, empty text or list, identity) count as empty. Raises :class:`SceneError` for other unknown
    keys.
    """
    data, harmless = _as_lists(data), list[str]()
    for place, key, meant in _unknown(data, kind) if isinstance(data, dict) else ():
        if key not in _HARMLESS:
            raise SceneError(f"{where}: '{place[:200]}' is not supported{meant}; remove it.")
        harmless.append(place)
    text = f"{where}: ignored, because no path depends on it: {choices(harmless)}."
    return validate(kind, data, where, SceneError), ((Note(text, grave=False),) if harmless else ())


def _as_lists(value: Any) -> Any:
    """Return plain data with vectors, rows and triangles as lists, as some exporters write them."""
    if isinstance(value, list):
        return [_as_lists(item) for item in value]
    if not isinstance(value, dict):
        return value
    keys = next((keys for keys in _AS_LISTS if value.keys() == set(keys)), None)
    if keys is None:
        return {key: _as_lists(item) for key, item in value.items()}
    return value[keys[0]] if len(keys) == 1 else [value[key] for key in keys]


def _unknown(data: dict[Any, Any], kind: type[Message], at: str = "") -> Iterator[tuple[str, str, str]]:
    """Yield path and name of nonempty keys that ``kind`` lacks, and a suggestion."""
    for key, value in data.items():
        field = kind.model_fields.get(key)
        if field is None and not _is_empty(value, str(key)):
            yield f"{at}{key}", str(key), suggest_name(str(key), kind.model_fields)
        for inner in models_in(field) if field else ():
            items = {f"{at}{key}.{k}.": item for k, item in enumerate(value)} if isinstance(value, list) else {}
            for here, item in (items or {f"{at}{key}.": value}).items():
                yield from _unknown(item, inner, here) if isinstance(item, dict) else ()


def _is_empty(value: Any, key: str) -> bool:
    """Return whether a value is a ROS default or consists of labels only."""
    if key in _LABELS or (key in ("scale", "weight") and value == 1.0):
        return True
    if isinstance(value, dict):
        return all(name in _HARMLESS or _is_empty(item, str(name)) for name, item in value.items())
    if isinstance(value, list):
        if key == "data":  # of cells a 0 says something too
            return not value
        is_identity = key in ("orientation", "rotation") and value[3:] in ([1], [-1])
        return all(_is_empty(item, key) for item in (value[:3] if is_identity else value))
    if isinstance(value, int | float):
        return abs(value) <= (_AT_REST if key == "velocity" else _SAME)
    return value in (None, "", "ADD", "add", "\0", b"\0")  # ADD is 0, a byte, in several spellings


def _require_direction(quaternion: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    pose(quaternion=quaternion)  # ValueError for one of zero length
    return quaternion


Triple = tuple[Coordinate, Coordinate, Coordinate]
Quaternion = Annotated[
    tuple[Coordinate, Coordinate, Coordinate, Coordinate], pydantic.AfterValidator(_require_direction)
]
Frame = Annotated[Name, pydantic.AfterValidator(lambda name: name.removeprefix("/"))]  # tf's first releases wrote it
Tolerance = Annotated[Number, pydantic.Field(ge=0)]
Solids = Sequence[tuple[str, tuple[float, ...], Floats]]
_Index = Annotated[Whole, pydantic.Field(ge=0, lt=2**31)]
_KINDS = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone", 5: "prism"}
_REGIONS = {"box": (3,), "sphere": (1,), "cylinder": range(9), "cone": range(9)}  # and how many dimensions they have


class Header(Message):
    frame_id: Frame = ""


class PoseMessage(Message):
    position: Triple = (0.0, 0.0, 0.0)
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def matrix(self) -> Floats:
        return pose(self.position, quaternion=self.orientation)


class Transform(Message):
    translation: Triple = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def matrix(self) -> Floats:
        return pose(self.translation, quaternion=self.rotation)


class TransformStamped(Message):
    header: Header = Header()
    child_frame_id: Frame
    transform: Transform = Transform()


class MeshMessage(Message):
    vertices: list[Triple]
    triangles: list[tuple[_Index, _Index, _Index]]


class SolidPrimitive(Message):
    """A solid, or a tolerance region, which may have zero size."""

    type: Name | Annotated[Whole, pydantic.Field(ge=0, le=255)]  # a byte in the message
    dimensions: tuple[Tolerance, ...]

    @property
    def kind(self) -> str:
        return (_KINDS.get(self.type, str(self.type)) if isinstance(self.type, int) else self.type).lower()


class CollisionObject(Message):
    header: Header = Header()
    pose: PoseMessage = PoseMessage()
    id: Name
    primitives: tuple[SolidPrimitive, ...] = ()
    primitive_poses: tuple[PoseMessage, ...] = ()
    meshes: tuple[MeshMessage, ...] = ()
    mesh_poses: tuple[PoseMessage, ...] = ()


class AttachedCollisionObject(Message):
    link_name: Name
    object: CollisionObject
    touch_links: tuple[Name, ...] = ()


def _require_fit(names: Sequence[Any], values: Sequence[Any], what: str, of: str) -> None:
    if len(names) != len(values):
        raise ValueError(f"there are {len(names)} {of} and {len(values)} {what}; give one each")


class JointState(Message):
    name: tuple[Name, ...] = ()
    position: tuple[Coordinate, ...] = ()

    @pydantic.model_validator(mode="after")
    def _one_each(self) -> JointState:
        _require_fit(self.name, self.position, "positions", "names")
        if twice := find_duplicates(self.name):
            raise ValueError(f"'{twice[0]}' is named twice; name each once")
        return self

    def values(self) -> dict[str, float]:
        return dict(zip(self.name, self.position, strict=True))


class RobotState(Message):
    joint_state: JointState = JointState()
    attached_collision_objects: tuple[AttachedCollisionObject, ...] = ()
    is_diff: bool = False


class AllowedCollisionMatrix(Message):
    entry_names: tuple[Name, ...] = ()
    entry_values: tuple[list[bool], ...] = ()

    @pydantic.model_validator(mode="after")
    def _square(self) -> AllowedCollisionMatrix:
        names, rows = self.entry_names, self.entry_values
        if any(len(part) != len(names) for part in (rows, *rows)):
            raise ValueError(f"there are {len(names)} entry_names; give as many entry_values, each of as many values")
        values = np.array(rows, dtype=bool).reshape(2 * (len(names),))
        for first, second in np.argwhere(values != values.T):
            raise ValueError(f"it allows '{names[first]}' and '{names[second]}' in one order only; make it symmetric")
        return self

    def pairs(self, allowed: bool) -> frozenset[frozenset[str]]:
        """Return the pairs of names that the matrix allows, or forbids, to touch."""
        names = self.entry_names
        rows, columns = np.nonzero(np.array(self.entry_values, dtype=bool) == allowed) if names else ((), ())
        return frozenset(frozenset((names[i], names[j])) for i, j in zip(rows, columns, strict=True) if i != j)


class Octomap(Message):
    """An octree as bytes; ``binary``: two bits per child, else a float per node."""

    binary: bool = False
    id: Name = ""
    resolution: Number = 0.0
    data: tuple[Annotated[Whole, pydantic.Field(ge=-128, le=255)], ...] = ()


class OctomapWithPose(Message):
    header: Header = Header()
    origin: PoseMessage = PoseMessage()
    octomap: Octomap = Octomap()


class World(Message):
    collision_objects: tuple[CollisionObject, ...] = ()
    octomap: OctomapWithPose = OctomapWithPose()


class PlanningSceneMessage(Message):
    name: Name = ""
    robot_state: RobotState = RobotState()
    robot_model_name: Name = ""
    fixed_frame_transforms: tuple[TransformStamped, ...] = ()
    allowed_collision_matrix: AllowedCollisionMatrix = AllowedCollisionMatrix()
    world: World = World()
    is_diff: bool = False


class BoundingVolume(Message):
    primitives: tuple[SolidPrimitive, ...] = ()
    primitive_poses: tuple[PoseMessage, ...] = ()  # points where there are no primitives

    @pydantic.model_validator(mode="after")
    def _require_poses(self) -> BoundingVolume:
        if self.primitives:
            _require_fit(self.primitives, self.primitive_poses, "primitive_poses", "primitives")
        for each in self.primitives:
            if len(each.dimensions) not in _REGIONS.get(each.kind, ()):
                raise ValueError(
                    f"a region of type '{each.kind}' with {len(each.dimensions)} dimensions is not supported; use box "
                    "[x, y, z], sphere [radius], cylinder or cone"
                )
        return self

    def solids(self) -> Solids:
        """Return the alternatives: kind of solid, dimensions and placement (4, 4)."""
        points = [("point", ())] * len(self.primitive_poses)
        named = [(each.kind, each.dimensions) for each in self.primitives] or points
        return [(*solid, each.matrix()) for solid, each in zip(named, self.primitive_poses, strict=True)]


class JointConstraint(Message):
    joint_name: Name
    position: Coordinate
    tolerance_above: Tolerance = 0.0
    tolerance_below: Tolerance = 0.0


class PositionConstraint(Message):
    header: Header = Header()
    link_name: Name = ""
    target_point_offset: Triple = (0.0, 0.0, 0.0)
    constraint_region: BoundingVolume = BoundingVolume()


class OrientationConstraint(Message):
    header: Header = Header()
    orientation: Quaternion
    link_name: Name = ""
    absolute_x_axis_tolerance: Tolerance = 0.0
    absolute_y_axis_tolerance: Tolerance = 0.0
    absolute_z_axis_tolerance: Tolerance = 0.0
    parameterization: Literal[0, 1] = 0  # angles about x, y and z, or a rotation vector

    @property
    def tolerances(self) -> tuple[float, float, float]:
        return self.absolute_x_axis_tolerance, self.absolute_y_axis_tolerance, self.absolute_z_axis_tolerance


class Constraints(Message):
    joint_constraints: tuple[JointConstraint, ...] = ()
    position_constraints: tuple[PositionConstraint, ...] = ()
    orientation_constraints: tuple[OrientationConstraint, ...] = ()

    @property
    def is_simplified(self) -> bool:
        """Whether tolerances are replaced by simpler ones inside them."""
        solids = [solid for each in self.position_constraints for solid in each.constraint_region.primitives]
        turns = any(any(each.tolerances) for each in self.orientation_constraints)
        return turns or any(each.kind != "box" and any(each.dimensions) for each in solids)


class MotionPlanRequestMessage(Message):
    start_state: RobotState
    goal_constraints: list[Constraints] = pydantic.Field(min_length=1)
    path_constraints: Constraints = Constraints()
    group_name: Name = ""
    max_velocity_scaling_factor: Number = 0.0
    max_acceleration_scaling_factor: Number = 0.0
