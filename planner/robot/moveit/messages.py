"""The parts of ROS messages that this planner follows, and one rule for all keys that they do not name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, TypeVar

import pydantic

from planner.base.arrays import Floats
from planner.base.errors import SceneError, choices
from planner.base.notes import Note
from planner.base.yamlfile import Coordinate, Name, Number, Size, Strict, Whole, models_in, nearest, repeated, validate
from planner.robot.poses import pose

_AT_REST = 0.01  # rad/s, m/s: encoders report this much of an arm that stands
_SAME = 1e-9  # numbers no further from a default are that default
_LABELS = {  # these name, date or colour something, at any place: by themselves they mean nothing
    "header", "stamp", "seq", "frame_id", "id", "name", "type", "link_name", "joint_names", "default_entry_names",
    "object_colors", "resolution", "binary",
}  # fmt: skip

_HARMLESS = {  # no path depends on these: one note names those that hold a value
    "subframe_names", "subframe_poses", "detach_posture", "weight", "effort", "wrench", "workspace_parameters",
    "reference_trajectories", "pipeline_id", "planner_id", "num_planning_attempts", "allowed_planning_time",
    "cartesian_speed_limited_link", "cartesian_speed_end_effector_link",
}  # fmt: skip

_REMEDIES = {
    "octomap": "give boxes or meshes in its place",
    "planes": "give a box in its place",
    "link_padding": "keep a distance from everything with --margin in its place",
    "link_scale": "keep a distance from everything with --margin in its place",
    "operation": "export the whole scene",
    "multi_dof_joint_state": "place the robot's base with --base",
    "velocity": "plan from where the arm comes to rest",
    "max_cartesian_speed": "lower max_velocity_scaling_factor in its place",
}
_AS_LISTS = ("xyz", "xyzw", ("enabled",), ("vertex_indices",))  # keys of messages that some exporters write as lists

Kind = TypeVar("Kind", bound="Message")


class Message(Strict):
    """Base of all messages; :func:`read_message` judges the keys that a message does not have."""

    model_config = pydantic.ConfigDict(extra="ignore")


def read_message(kind: type[Kind], data: Any, where: str) -> tuple[Kind, tuple[Note, ...]]:
    """A message out of plain data, and a note of its harmless keys; :class:`SceneError` for any other key with a value.

    A value that ROS fills in by itself (0, an empty text or list, an identity) counts as none.
    """
    data, harmless = _as_lists(data), dict[str, None]()
    for place, key, is_harmless, meant in _unknown(data, kind) if isinstance(data, dict) else ():
        if not is_harmless:
            remedy = _REMEDIES.get(key, "take it out")
            raise SceneError(f"{where}: '{place[:200]}' is not followed by this planner{meant}; {remedy}.")
        harmless[place] = None
    text = f"{where}: passed over, as no path depends on it: {choices(harmless)}."
    return validate(kind, data, where, SceneError), ((Note(text, grave=False),) if harmless else ())


def _as_lists(value: Any) -> Any:
    """Plain data with vectors, rows and triangles as lists, as some exporters write them."""
    if isinstance(value, list):
        return [_as_lists(item) for item in value]
    if not isinstance(value, dict):
        return value
    keys = next((keys for keys in _AS_LISTS if value.keys() == set(keys)), None)
    if keys is None:
        return {key: _as_lists(item) for key, item in value.items()}
    return value[keys[0]] if len(keys) == 1 else [value[key] for key in keys]


def _unknown(data: dict[Any, Any], kind: type[Message], at: str = "") -> Iterator[tuple[str, str, bool, str]]:
    """Of keys that ``kind`` lacks: the place of each value, the key, if it is harmless, and which one was meant."""
    for key, value in data.items():
        place, field = f"{at}{key}", kind.model_fields.get(key)
        if field is None:
            meant = nearest(str(key), kind.model_fields)
            yield from ((inner, key, is_harmless, meant) for inner, is_harmless in _values(value, place, str(key)))
        for inner in models_in(field) if field else ():
            items = {f"{place}.{k}.": item for k, item in enumerate(value)} if isinstance(value, list) else {}
            for here, item in (items or {f"{place}.": value}).items():
                yield from _unknown(item, inner, here) if isinstance(item, dict) else ()


def _values(value: Any, place: str, key: str) -> Iterator[tuple[str, bool]]:
    """The places of values that are not the default ones, and if they are harmless."""
    if key in _HARMLESS:
        if value != 1.0 and any(True for _ in _values(value, place, "")):  # a weight of 1 is no choice
            yield place, True
    elif key in _LABELS or (key == "scale" and value == 1.0):
        return
    elif isinstance(value, dict):
        for name, item in value.items():
            yield from _values(item, f"{place}.{name}", str(name))
    elif isinstance(value, list):
        items = value[:3] if key in ("orientation", "rotation") and value[3:] in ([1], [-1]) else value
        for k, item in enumerate(items):
            yield from _values(item, f"{place}.{k}" if isinstance(item, dict | list) else place, key)
        if key == "data" and value:  # of cells a 0 says something too
            yield place, False
    elif isinstance(value, int | float):
        if not abs(value) <= _SAME:
            yield place, key == "velocity" and abs(value) <= _AT_REST
    elif value not in (None, "", "ADD", "add", "\0", b"\0"):  # ADD is 0, a byte, in several spellings
        yield place, False


def _turning(quaternion: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    pose(quaternion=quaternion)  # ValueError for one of zero length
    return quaternion


Triple = tuple[Coordinate, Coordinate, Coordinate]
Quaternion = Annotated[tuple[Coordinate, Coordinate, Coordinate, Coordinate], pydantic.AfterValidator(_turning)]
Frame = Annotated[Name, pydantic.AfterValidator(lambda name: name.removeprefix("/"))]  # tf's first releases wrote it
Tolerance = Annotated[Number, pydantic.Field(ge=0)]
_Index = Annotated[Whole, pydantic.Field(ge=0, lt=2**31)]
_KINDS = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone", 5: "prism"}


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


class TransformStamped(Message):
    header: Header = Header()
    child_frame_id: Frame
    transform: Transform = Transform()


class MeshMessage(Message):
    vertices: list[Triple]
    triangles: list[tuple[_Index, _Index, _Index]]


class Solid(Message):
    type: Name | Annotated[Whole, pydantic.Field(ge=0, le=255)]  # a byte in the message

    @property
    def kind(self) -> str:
        return (_KINDS.get(self.type, str(self.type)) if isinstance(self.type, int) else self.type).lower()


class SolidPrimitive(Solid):
    dimensions: list[Size]


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


def require_fit(names: Sequence[Any], values: Sequence[Any], what: str, of: str) -> None:
    if len(names) != len(values):
        raise ValueError(f"there are {len(names)} {of} and {len(values)} {what}; give one each")


def require_once(names: Sequence[str]) -> None:
    if twice := repeated(names):
        raise ValueError(f"'{twice[0]}' is named twice; name each once")


class JointState(Message):
    name: tuple[Name, ...] = ()
    position: tuple[Coordinate, ...] = ()

    @pydantic.model_validator(mode="after")
    def _one_each(self) -> JointState:
        require_fit(self.name, self.position, "positions", "names")
        require_once(self.name)
        return self

    def values(self) -> dict[str, float]:
        return dict(zip(self.name, self.position, strict=True))


class RobotState(Message):
    joint_state: JointState = JointState()
    attached_collision_objects: tuple[AttachedCollisionObject, ...] = ()
    is_diff: bool = False
