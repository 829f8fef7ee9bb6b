"""The messages that scenes and requests are made of: geometry, shapes, robot states, as ROS 1 and 2 define them.

A mark says that a field is not honoured, see :mod:`planner.models.files.moveit.fields`; an unknown key is an error.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.yamlfile import Coordinate, Name, Number, Size, Strict, Whole, repeated
from planner.models.files.moveit.fields import Label, Noted, Refused, none
from planner.models.poses import pose

AT_REST = 0.01  # rad/s, m/s: what encoders report of an arm that stands
_SAME = 1e-9  # m, and of a matrix's entries


def _vector(value: Any) -> Any:
    """ROS writes vectors as {x, y, z} or, through some exporters, as lists."""
    if not isinstance(value, dict) or set(value) not in (set("xyz"), set("xyzw")):
        return value
    return [value[axis] for axis in "xyzw" if axis in value]


Triple: TypeAlias = Annotated[tuple[Coordinate, Coordinate, Coordinate], pydantic.BeforeValidator(_vector)]
Quaternion: TypeAlias = Annotated[
    tuple[Coordinate, Coordinate, Coordinate, Coordinate], pydantic.BeforeValidator(_vector)
]
Tag = Annotated[Any, Label]
Text = Annotated[Name, Label]


class Header(Strict):
    seq: Tag = 0
    stamp: Tag = None
    frame_id: Text = ""


class PoseMessage(Strict):
    position: Triple = (0.0, 0.0, 0.0)
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    @pydantic.model_validator(mode="after")
    def _turned(self) -> PoseMessage:
        self.matrix()  # ValueError for a quaternion of zero length
        return self

    def matrix(self) -> Floats:
        return pose(self.position, quaternion=self.orientation)


class PoseStamped(Strict):
    header: Annotated[Header, Label] = Header()
    pose: PoseMessage = PoseMessage()


class Transform(Strict):
    translation: Triple = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def matrix(self) -> Floats:
        return pose(self.translation, quaternion=self.rotation)


class TransformStamped(Strict):
    header: Header = Header()
    child_frame_id: Name
    transform: Transform = Transform()


class Twist(Strict):
    linear: Triple = (0.0, 0.0, 0.0)
    angular: Triple = (0.0, 0.0, 0.0)


class Wrench(Strict):
    force: Triple = (0.0, 0.0, 0.0)
    torque: Triple = (0.0, 0.0, 0.0)


_Index = Annotated[Whole, pydantic.Field(ge=0, lt=2**31)]


class Triangle(Strict):
    vertex_indices: tuple[_Index, _Index, _Index]


class MeshMessage(Strict):
    vertices: list[Triple]
    triangles: list[Triangle]


class Plane(Strict):
    coef: list[Number] = none()


_Kind = Name | Annotated[Whole, pydantic.Field(ge=0, le=255)]  # a byte in the message
_KINDS = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone", 5: "prism"}


class Solid(Strict):
    type: _Kind
    polygon: Tag = None  # of a prism, which is refused by its type

    @property
    def kind(self) -> str:
        return (_KINDS.get(self.type, str(self.type)) if isinstance(self.type, int) else self.type).lower()


class SolidPrimitive(Solid):
    dimensions: list[Size]


def fits(names: Sequence[Any], values: Sequence[Any], what: str, of: str) -> None:
    if len(names) != len(values):
        raise ValueError(f"there are {len(names)} {of} and {len(values)} {what}; give one each")


class ObjectType(Strict):
    key: Tag = ""
    db: Tag = ""


class CollisionObject(Strict):
    header: Header = Header()
    pose: PoseMessage = PoseMessage()
    id: Name
    type: Annotated[ObjectType, Label] = ObjectType()
    primitives: list[SolidPrimitive] = none()
    primitive_poses: list[PoseMessage] = none()
    meshes: list[MeshMessage] = none()
    mesh_poses: list[PoseMessage] = none()
    planes: Annotated[
        list[Plane], Refused("is a plane without end, which is not supported: give a box in its place", when=bool)
    ] = none()
    plane_poses: list[PoseMessage] = none()
    subframe_names: Annotated[list[Name], Noted("frames on objects are passed over")] = none()
    subframe_poses: list[PoseMessage] = none()
    operation: Annotated[
        Whole | Name,
        Refused(
            "is not ADD (0): a message that removes, moves or appends changes a scene that is not here; export the "
            "whole scene",
            when=lambda value: value not in (0, "ADD", "add", "", "\0"),
        ),
    ] = 0

    @pydantic.model_validator(mode="after")
    def _one_pose_each(self) -> CollisionObject:
        if self.plane_poses:
            fits(self.planes, self.plane_poses, "plane_poses", "planes")
        if self.subframe_poses:
            fits(self.subframe_names, self.subframe_poses, "subframe_poses", "subframe_names")
        return self


class JointTrajectory(Strict):
    header: Annotated[Header, Label] = Header()
    joint_names: list[Name] = none()
    points: list[Any] = none()


class AttachedCollisionObject(Strict):
    link_name: Name
    object: CollisionObject
    touch_links: list[Name] = none()
    detach_posture: Annotated[JointTrajectory, Noted("how a gripper lets go is passed over")] = JointTrajectory()
    weight: Annotated[Number, Noted("weights of attached objects are passed over")] = 0.0


def _moves(velocity: Sequence[float]) -> bool:
    return max(map(abs, velocity), default=0.0) > AT_REST


class JointState(Strict):
    header: Annotated[Header, Label] = Header()
    name: list[Name] = none()
    position: list[Coordinate] = none()
    velocity: Annotated[
        list[Number],
        Refused(f"is above {AT_REST:g}: motions begin at rest; plan from where the arm comes to rest", when=_moves),
        Noted(
            "velocities at the start this low are taken for rest", when=lambda value: any(value) and not _moves(value)
        ),
    ] = none()
    effort: Annotated[list[Number], Noted("efforts at the start are passed over")] = none()

    @pydantic.model_validator(mode="after")
    def _one_each(self) -> JointState:
        fits(self.name, self.position, "positions", "names")
        for what in ("velocity", "effort"):
            if getattr(self, what):
                fits(self.name, getattr(self, what), what, "names")
        twice = repeated(self.name)
        if twice:
            raise ValueError(f"'{twice[0]}' is named twice; name each once")
        return self

    def values(self) -> dict[str, float]:
        return dict(zip(self.name, self.position, strict=True))


def _moved(transforms: Sequence[Transform]) -> bool:
    return any(np.abs(each.matrix() - np.eye(4)).max() > _SAME for each in transforms)


class MultiDOFJointState(Strict):
    header: Annotated[Header, Label] = Header()
    joint_names: list[Name] = none()
    transforms: Annotated[
        list[Transform],
        Refused("moves the robot's base: say where it stands with --base, and leave identities here", when=_moved),
    ] = none()
    twist: Annotated[list[Twist], Refused("is not 0: motions begin at rest, on a base that stands")] = none()
    wrench: Annotated[list[Wrench], Noted("efforts at the start are passed over")] = none()

    @pydantic.model_validator(mode="after")
    def _one_each(self) -> MultiDOFJointState:
        fits(self.joint_names, self.transforms, "transforms", "joint_names")
        return self


class RobotState(Strict):
    joint_state: JointState = JointState()
    multi_dof_joint_state: MultiDOFJointState = MultiDOFJointState()
    attached_collision_objects: list[AttachedCollisionObject] = none()
    is_diff: bool = False
