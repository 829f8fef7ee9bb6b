"""The messages as moveit_msgs and the packages below it define them (ROS 1 and 2), and what becomes of each field.

In their order: geometry, shapes, robot states, PlanningScene, constraints, MotionPlanRequest. A mark says that a field
is not honoured, see :mod:`planner.world.moveit.fields`; an unknown key is an error.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np
import pydantic

from planner.base.arrays import Floats
from planner.base.yamlfile import Coordinate, Name, Size, Strict
from planner.world.moveit.fields import Label, Noted, Refused
from planner.world.poses import pose

AT_REST = 0.01  # rad/s, m/s: what encoders report of an arm that stands
_SAME = 1e-9  # m, and of a matrix's entries
_KNOWN_FACTORS = (0.0, 1.0)


def _vector(value: Any) -> Any:
    """ROS writes vectors as {x, y, z} or, through some exporters, as lists."""
    if not isinstance(value, dict) or not set(value) <= set("xyzw"):
        return value
    return [value[axis] for axis in "xyzw" if axis in value]


def _row(value: Any) -> Any:
    """ROS writes a row as {enabled: [...]} or, through some exporters, as the list itself."""
    return value["enabled"] if isinstance(value, dict) and set(value) == {"enabled"} else value


Triple: TypeAlias = Annotated[tuple[Coordinate, Coordinate, Coordinate], pydantic.BeforeValidator(_vector)]
Quaternion: TypeAlias = Annotated[
    tuple[Coordinate, Coordinate, Coordinate, Coordinate], pydantic.BeforeValidator(_vector)
]
_Tag = Annotated[Any, Label]
_Text = Annotated[Name, Label]
_CENTRE = Noted("goals are reached at the centre of their tolerances")
_Tolerance = Annotated[float, pydantic.Field(ge=0), _CENTRE]
_Weight = Annotated[
    float, Noted("all constraints are kept, whatever their weights", when=lambda value: value not in _KNOWN_FACTORS)
]
_SETTINGS = Noted("passed over, as only MoveIt's own planners or a moving base need it")
_LATER = "is not kept by this planner: take it out, and look at the motion that is planned without it"


class Header(Strict):
    seq: _Tag = 0
    stamp: _Tag = None
    frame_id: _Text = ""


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


_Index = Annotated[int, pydantic.Field(ge=0, lt=2**31)]


class Triangle(Strict):
    vertex_indices: tuple[_Index, _Index, _Index]


class MeshMessage(Strict):
    vertices: list[Triple]
    triangles: list[Triangle]


class Plane(Strict):
    coef: list[float] = pydantic.Field(default_factory=list)


_Kind = Name | Annotated[int, pydantic.Field(ge=0, le=255)]  # a byte in the message
_KINDS = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone", 5: "prism"}


class _Solid(Strict):
    type: _Kind
    polygon: _Tag = None  # of a prism, which is refused by its type

    @property
    def kind(self) -> str:
        return (_KINDS.get(self.type, str(self.type)) if isinstance(self.type, int) else self.type).lower()


class SolidPrimitive(_Solid):
    dimensions: list[Size]


class _Region(_Solid):
    """A primitive as a goal's tolerance: it may have no size."""

    dimensions: Annotated[list[Annotated[float, pydantic.Field(ge=0)]], _CENTRE]

    @pydantic.model_validator(mode="after")
    def _around_its_origin(self) -> _Region:
        if self.kind not in ("box", "sphere", "cylinder", "cone"):
            raise ValueError(f"a goal region of type '{self.kind}' is not supported; use box, sphere, cylinder or cone")
        return self


def _fits(names: Sequence[Any], values: Sequence[Any], what: str, of: str) -> None:
    if len(names) != len(values):
        raise ValueError(f"there are {len(names)} {of} and {len(values)} {what}; give one each")


class BoundingVolume(Strict):
    primitives: list[_Region] = pydantic.Field(default_factory=list)
    primitive_poses: list[PoseMessage] = pydantic.Field(default_factory=list)
    meshes: Annotated[
        list[MeshMessage], Refused("is a goal region without a centre: use box, sphere, cylinder or cone", when=bool)
    ] = pydantic.Field(default_factory=list)
    mesh_poses: list[PoseMessage] = pydantic.Field(default_factory=list)

    @pydantic.model_validator(mode="after")
    def _placed(self) -> BoundingVolume:
        if self.primitives:  # without them the poses are points
            _fits(self.primitives, self.primitive_poses, "primitive_poses", "primitives")
        return self


class ObjectType(Strict):
    key: _Tag = ""
    db: _Tag = ""


class CollisionObject(Strict):
    header: Header = Header()
    pose: PoseMessage = PoseMessage()
    id: Name
    type: Annotated[ObjectType, Label] = ObjectType()
    primitives: list[SolidPrimitive] = pydantic.Field(default_factory=list)
    primitive_poses: list[PoseMessage] = pydantic.Field(default_factory=list)
    meshes: list[MeshMessage] = pydantic.Field(default_factory=list)
    mesh_poses: list[PoseMessage] = pydantic.Field(default_factory=list)
    planes: Annotated[
        list[Plane], Refused("is a plane without end, which is not supported: give a box in its place", when=bool)
    ] = pydantic.Field(default_factory=list)
    plane_poses: list[PoseMessage] = pydantic.Field(default_factory=list)
    subframe_names: Annotated[list[Name], Noted("frames on objects are passed over")] = pydantic.Field(
        default_factory=list
    )
    subframe_poses: list[PoseMessage] = pydantic.Field(default_factory=list)
    operation: Annotated[
        int | Name,
        Refused(
            "is not ADD (0): a message that removes, moves or appends changes a scene that is not here; export the "
            "whole scene",
            when=lambda value: value not in (0, "ADD", "add", "", "\0"),
        ),
    ] = 0


class JointTrajectory(Strict):
    header: Annotated[Header, Label] = Header()
    joint_names: list[Name] = pydantic.Field(default_factory=list)
    points: list[Any] = pydantic.Field(default_factory=list)


class AttachedCollisionObject(Strict):
    link_name: Name
    object: CollisionObject
    touch_links: list[Name] = pydantic.Field(default_factory=list)
    detach_posture: Annotated[JointTrajectory, Noted("how a gripper lets go is passed over")] = JointTrajectory()
    weight: Annotated[float, Noted("weights of attached objects are passed over")] = 0.0


def _moves(velocity: Sequence[float]) -> bool:
    return max(map(abs, velocity), default=0.0) > AT_REST


class JointState(Strict):
    header: Annotated[Header, Label] = Header()
    name: list[Name] = pydantic.Field(default_factory=list)
    position: list[Coordinate] = pydantic.Field(default_factory=list)
    velocity: Annotated[
        list[float],
        Refused(f"is above {AT_REST:g}: motions begin at rest; plan from where the arm comes to rest", when=_moves),
        Noted(
            "velocities at the start this low are taken for rest", when=lambda value: any(value) and not _moves(value)
        ),
    ] = pydantic.Field(default_factory=list)
    effort: Annotated[list[float], Noted("efforts at the start are passed over")] = pydantic.Field(default_factory=list)

    @pydantic.model_validator(mode="after")
    def _one_each(self) -> JointState:
        _fits(self.name, self.position, "positions", "names")
        for what in ("velocity", "effort"):
            if getattr(self, what):
                _fits(self.name, getattr(self, what), what, "names")
        _once(self.name)
        return self

    def values(self) -> dict[str, float]:
        return dict(zip(self.name, self.position, strict=True))


def _once(names: Sequence[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"'{twice[0]}' is named twice; name each once")


def _moved(transforms: Sequence[Transform]) -> bool:
    return any(np.abs(each.matrix() - np.eye(4)).max() > _SAME for each in transforms)


class MultiDOFJointState(Strict):
    header: Annotated[Header, Label] = Header()
    joint_names: list[Name] = pydantic.Field(default_factory=list)
    transforms: Annotated[
        list[Transform],
        Refused("moves the robot's base: say where it stands with --base, and leave identities here", when=_moved),
    ] = pydantic.Field(default_factory=list)
    twist: Annotated[list[Twist], Refused("is not 0: motions begin at rest, on a base that stands")] = pydantic.Field(
        default_factory=list
    )
    wrench: Annotated[list[Wrench], Noted("efforts at the start are passed over")] = pydantic.Field(
        default_factory=list
    )

    @pydantic.model_validator(mode="after")
    def _one_each(self) -> MultiDOFJointState:
        _fits(self.joint_names, self.transforms, "transforms", "joint_names")
        return self


class RobotState(Strict):
    joint_state: JointState = JointState()
    multi_dof_joint_state: MultiDOFJointState = MultiDOFJointState()
    attached_collision_objects: list[AttachedCollisionObject] = pydantic.Field(default_factory=list)
    is_diff: bool = False


class AllowedCollisionMatrix(Strict):
    entry_names: list[Name] = pydantic.Field(default_factory=list)
    entry_values: list[Annotated[list[bool], pydantic.BeforeValidator(_row)]] = pydantic.Field(default_factory=list)
    default_entry_names: list[Name] = pydantic.Field(default_factory=list)
    default_entry_values: Annotated[
        list[bool], Refused("allows contacts of whole links or objects: allow pairs, in entry_names and entry_values")
    ] = pydantic.Field(default_factory=list)

    @pydantic.model_validator(mode="after")
    def _square(self) -> AllowedCollisionMatrix:
        _fits(self.entry_names, self.entry_values, "entry_values", "entry_names")
        _fits(self.default_entry_names, self.default_entry_values, "default_entry_values", "default_entry_names")
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

    def allowed(self) -> frozenset[frozenset[str]]:
        """The pairs of names that may touch."""
        return frozenset(
            frozenset((first, second))
            for first, row in zip(self.entry_names, self.entry_values, strict=True)
            for second, value in zip(self.entry_names, row, strict=True)
            if value and first != second
        )


class LinkPadding(Strict):
    link_name: _Text = ""
    padding: float = 0.0


class LinkScale(Strict):
    link_name: _Text = ""
    scale: float = 1.0


class ObjectColor(Strict):
    id: _Tag = ""
    color: _Tag = None


class Octomap(Strict):
    header: Annotated[Header, Label] = Header()
    binary: _Tag = False
    id: _Tag = ""
    resolution: _Tag = 0.0
    data: list[Any] | str = pydantic.Field(default_factory=list)


class OctomapWithPose(Strict):
    header: Annotated[Header, Label] = Header()
    origin: Annotated[PoseMessage, Label] = PoseMessage()
    octomap: Octomap = Octomap()


class PlanningSceneWorld(Strict):
    collision_objects: list[CollisionObject] = pydantic.Field(default_factory=list)
    octomap: Annotated[
        OctomapWithPose, Refused("is not read, so what it holds would not be seen: give boxes or meshes in its place")
    ] = OctomapWithPose()


class PlanningSceneMessage(Strict):
    name: Name = ""
    robot_state: RobotState = RobotState()
    robot_model_name: Name = ""
    fixed_frame_transforms: list[TransformStamped] = pydantic.Field(default_factory=list)
    allowed_collision_matrix: AllowedCollisionMatrix = AllowedCollisionMatrix()
    link_padding: Annotated[
        list[LinkPadding], Refused("is not 0: keep a distance from everything with --margin in its place")
    ] = pydantic.Field(default_factory=list)
    link_scale: Annotated[
        list[LinkScale],
        Refused(
            "is not 1: keep a distance from everything with --margin in its place",
            when=lambda value: any(each.scale != 1.0 for each in value),
        ),
    ] = pydantic.Field(default_factory=list)
    object_colors: Annotated[list[ObjectColor], Label] = pydantic.Field(default_factory=list)
    world: PlanningSceneWorld = PlanningSceneWorld()
    is_diff: Annotated[
        bool, Noted("it is a difference to a scene that is not here, and is taken for the whole", grave=True)
    ] = False


class JointConstraint(Strict):
    joint_name: Name
    position: Coordinate
    tolerance_above: _Tolerance = 0.0
    tolerance_below: _Tolerance = 0.0
    weight: _Weight = 0.0


class PositionConstraint(Strict):
    header: Header = Header()
    link_name: Name = ""
    target_point_offset: Triple = (0.0, 0.0, 0.0)
    constraint_region: BoundingVolume = BoundingVolume()
    weight: _Weight = 0.0


class OrientationConstraint(Strict):
    header: Header = Header()
    orientation: Quaternion
    link_name: Name = ""
    absolute_x_axis_tolerance: _Tolerance = 0.0
    absolute_y_axis_tolerance: _Tolerance = 0.0
    absolute_z_axis_tolerance: _Tolerance = 0.0
    parameterization: _Tag = 0
    weight: _Weight = 0.0

    @pydantic.model_validator(mode="after")
    def _turned(self) -> OrientationConstraint:
        self.matrix()
        return self

    def matrix(self) -> Floats:
        return pose(quaternion=self.orientation)


class VisibilityConstraint(Strict):
    target_radius: float = 0.0
    target_pose: PoseStamped = PoseStamped()
    cone_sides: int = 0
    sensor_pose: PoseStamped = PoseStamped()
    max_view_angle: float = 0.0
    max_range_angle: float = 0.0
    sensor_view_direction: int = 0
    weight: _Weight = 0.0


class Constraints(Strict):
    name: _Text = ""
    joint_constraints: list[JointConstraint] = pydantic.Field(default_factory=list)
    position_constraints: list[PositionConstraint] = pydantic.Field(default_factory=list)
    orientation_constraints: list[OrientationConstraint] = pydantic.Field(default_factory=list)
    visibility_constraints: Annotated[list[VisibilityConstraint], Refused(_LATER, when=bool)] = pydantic.Field(
        default_factory=list
    )

    @property
    def empty(self) -> bool:
        kinds = (self.joint_constraints, self.position_constraints, self.orientation_constraints)
        return not any((*kinds, self.visibility_constraints))


class TrajectoryConstraints(Strict):
    constraints: list[Constraints] = pydantic.Field(default_factory=list)


class GenericTrajectory(Strict):
    header: Annotated[Header, Label] = Header()
    joint_trajectory: list[Any] = pydantic.Field(default_factory=list)
    cartesian_trajectory: list[Any] = pydantic.Field(default_factory=list)


class WorkspaceParameters(Strict):
    header: Annotated[Header, Label] = Header()
    min_corner: Triple = (0.0, 0.0, 0.0)
    max_corner: Triple = (0.0, 0.0, 0.0)


def _no_share(value: float) -> bool:
    return not 0.0 <= value <= 1.0


_Factor = Annotated[float, Noted("outside (0, 1], and taken as 1, as MoveIt does", when=_no_share, grave=True)]


class MotionPlanRequestMessage(Strict):
    workspace_parameters: Annotated[WorkspaceParameters, _SETTINGS] = WorkspaceParameters()
    start_state: RobotState
    goal_constraints: list[Constraints] = pydantic.Field(min_length=1)
    path_constraints: Annotated[Constraints, Refused(_LATER, when=lambda value: not value.empty)] = Constraints()
    trajectory_constraints: Annotated[
        TrajectoryConstraints, Refused(_LATER, when=lambda value: not all(each.empty for each in value.constraints))
    ] = TrajectoryConstraints()
    reference_trajectories: Annotated[list[GenericTrajectory], _SETTINGS] = pydantic.Field(default_factory=list)
    pipeline_id: Annotated[Name, _SETTINGS] = ""
    planner_id: Annotated[Name, _SETTINGS] = ""
    group_name: Name = ""
    num_planning_attempts: Annotated[int, _SETTINGS] = 0
    allowed_planning_time: Annotated[float, _SETTINGS] = 0.0
    max_velocity_scaling_factor: _Factor = 0.0
    max_acceleration_scaling_factor: _Factor = 0.0
    cartesian_speed_limited_link: _Text = ""
    cartesian_speed_end_effector_link: _Text = ""  # as it was called at first
    max_cartesian_speed: Annotated[
        float,
        Refused(
            "limits the speed of a link, which is not kept: take it out, and lower max_velocity_scaling_factor",
            when=lambda value: value > 0,
        ),
    ] = 0.0
