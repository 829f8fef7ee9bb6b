"""MotionPlanRequest messages: constraints, the request, and what we take from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import pydantic

from planner.base.arrays import Floats
from planner.base.errors import SceneError, choices
from planner.base.notes import Note
from planner.base.places import Place, place
from planner.base.yamlfile import Coordinate, Name, Strict, parse_yaml, read_text, shown, validate
from planner.models.files.moveit.fields import Label, Noted, Refused, none, notes_of
from planner.models.files.moveit.messages import (
    Header,
    MeshMessage,
    PoseMessage,
    PoseStamped,
    Quaternion,
    RobotState,
    Solid,
    Tag,
    Text,
    Triple,
    fits,
)
from planner.models.files.moveit.objects import carried
from planner.models.poses import pose
from planner.models.shapes import Carried

_CENTRE = Noted("goals are reached at the centre of their tolerances")
_Tolerance = Annotated[float, pydantic.Field(ge=0), _CENTRE]
_KNOWN_FACTORS = (0.0, 1.0)
_Weight = Annotated[
    float, Noted("all constraints are kept, whatever their weights", when=lambda value: value not in _KNOWN_FACTORS)
]
_SETTINGS = Noted("passed over, as only MoveIt's own planners or a moving base need it")
_LATER = "is not kept by this planner: take it out, and look at the motion that is planned without it"


class _Region(Solid):
    """A primitive as a goal's tolerance: it may have no size."""

    dimensions: Annotated[list[Annotated[float, pydantic.Field(ge=0)]], _CENTRE]

    @pydantic.model_validator(mode="after")
    def _around_its_origin(self) -> _Region:
        if self.kind not in ("box", "sphere", "cylinder", "cone"):
            raise ValueError(f"a goal region of type '{self.kind}' is not supported; use box, sphere, cylinder or cone")
        return self


class BoundingVolume(Strict):
    primitives: list[_Region] = none()
    primitive_poses: list[PoseMessage] = none()
    meshes: Annotated[
        list[MeshMessage], Refused("is a goal region without a centre: use box, sphere, cylinder or cone", when=bool)
    ] = none()
    mesh_poses: list[PoseMessage] = none()

    @pydantic.model_validator(mode="after")
    def _placed(self) -> BoundingVolume:
        if self.primitives:  # without them the poses are points
            fits(self.primitives, self.primitive_poses, "primitive_poses", "primitives")
        return self


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
    parameterization: Tag = 0
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
    name: Text = ""
    joint_constraints: list[JointConstraint] = none()
    position_constraints: list[PositionConstraint] = none()
    orientation_constraints: list[OrientationConstraint] = none()
    visibility_constraints: Annotated[list[VisibilityConstraint], Refused(_LATER, when=bool)] = none()

    @property
    def empty(self) -> bool:
        kinds = (self.joint_constraints, self.position_constraints, self.orientation_constraints)
        return not any((*kinds, self.visibility_constraints))


class TrajectoryConstraints(Strict):
    constraints: list[Constraints] = none()


class GenericTrajectory(Strict):
    header: Annotated[Header, Label] = Header()
    joint_trajectory: list[Any] = none()
    cartesian_trajectory: list[Any] = none()


class WorkspaceParameters(Strict):
    header: Annotated[Header, Label] = Header()
    min_corner: Triple = (0.0, 0.0, 0.0)
    max_corner: Triple = (0.0, 0.0, 0.0)


_Factor = Annotated[
    float,
    Noted("outside (0, 1], and taken as 1, as MoveIt does", when=lambda value: not 0.0 <= value <= 1.0, grave=True),
]


class MotionPlanRequestMessage(Strict):
    workspace_parameters: Annotated[WorkspaceParameters, _SETTINGS] = WorkspaceParameters()
    start_state: RobotState
    goal_constraints: list[Constraints] = pydantic.Field(min_length=1)
    path_constraints: Annotated[Constraints, Refused(_LATER, when=lambda value: not value.empty)] = Constraints()
    trajectory_constraints: Annotated[
        TrajectoryConstraints, Refused(_LATER, when=lambda value: not all(each.empty for each in value.constraints))
    ] = TrajectoryConstraints()
    reference_trajectories: Annotated[list[GenericTrajectory], _SETTINGS] = none()
    pipeline_id: Annotated[Name, _SETTINGS] = ""
    planner_id: Annotated[Name, _SETTINGS] = ""
    group_name: Name = ""
    num_planning_attempts: Annotated[int, _SETTINGS] = 0
    allowed_planning_time: Annotated[float, _SETTINGS] = 0.0
    max_velocity_scaling_factor: _Factor = 0.0
    max_acceleration_scaling_factor: _Factor = 0.0
    cartesian_speed_limited_link: Text = ""
    cartesian_speed_end_effector_link: Text = ""  # as it was called at first
    max_cartesian_speed: Annotated[
        float,
        Refused(
            "limits the speed of a link, which is not kept: take it out, and lower max_velocity_scaling_factor",
            when=lambda value: value > 0,
        ),
    ] = 0.0


@dataclass(frozen=True)
class JointGoal:
    """Joint values by name, and how far below and above each will do."""

    values: Mapping[str, float]
    tolerances: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class LinkGoal:
    """Where a link is to be, the tool frame where ``link`` is empty.

    ``position`` (m) is that of the point ``offset`` of the link, ``quaternion`` its orientation, None for any; each in
    a frame of its own, which is the scene's where its name is empty.
    """

    link: str
    position: tuple[float, ...]
    frame: str = ""
    offset: tuple[float, ...] = (0.0, 0.0, 0.0)
    quaternion: tuple[float, ...] | None = None
    turn_frame: str = ""


@dataclass(frozen=True)
class MotionPlanRequest:
    """What a request asks: a start by joint names, what is carried, alternative goals, shares of the limits.

    ``group`` is empty where the request names none. ``shares``, of velocity and of acceleration, are there where the
    request says one. A start that ``replaces`` the scene's is no difference to it.
    """

    where: str
    start: Mapping[str, float]
    goals: tuple[JointGoal | LinkGoal, ...]
    group: str
    carried: tuple[Carried, ...]
    replaces: bool
    shares: Mapping[str, float]
    notes: tuple[Note, ...]


def read_motion_plan_request(path: Place) -> MotionPlanRequest:
    """The request at ``path``; :class:`SceneError` for what cannot be read, or a field that changes what is asked."""
    path = place(path)
    where = f"MotionPlanRequest {path}"
    data = parse_yaml(read_text(path, "MotionPlanRequest"), where)
    message = validate(MotionPlanRequestMessage, data, where, SceneError)
    start, notes = message.start_state, notes_of(message, where)
    factors = {kind: getattr(message, f"max_{kind}_scaling_factor") for kind in ("velocity", "acceleration")}
    return MotionPlanRequest(
        where,
        start.joint_state.values(),
        tuple(
            goal for k, item in enumerate(message.goal_constraints) for goal in _goals(item, f"{where}: goal {k + 1}")
        ),
        message.group_name,
        carried(start.attached_collision_objects, where),
        not start.is_diff,
        {kind: min(factor, 1.0) for kind, factor in factors.items() if factor > 0.0},
        notes,
    )


def _goals(item: Constraints, where: str) -> list[JointGoal | LinkGoal]:
    """The goals that reach all constraints: one in joints, or one for each place of the region of a position."""
    joints, positions, turns = item.joint_constraints, item.position_constraints, item.orientation_constraints
    if joints and (positions or turns):
        raise SceneError(f"{where} constrains joints and a link at once, which is not supported; give one of the two.")
    if joints:
        values = {each.joint_name: each.position for each in joints}
        if len(values) < len(joints):
            raise SceneError(
                f"{where} constrains a joint twice, one of {choices(values)}; give one constraint a joint."
            )
        return [JointGoal(values, {each.joint_name: (each.tolerance_below, each.tolerance_above) for each in joints})]
    for what, found in (("position_constraints", positions), ("orientation_constraints", turns)):
        if len(found) > 1:
            raise SceneError(f"{where} has {len(found)} {what} to keep at once, which is not supported; give one.")
    if not positions or not positions[0].constraint_region.primitive_poses:
        raise SceneError(f"{where} has neither joint nor position constraints; add one of them.")
    return _link_goals(positions[0], turns[0] if turns else None, where)


def _link_goals(
    place: PositionConstraint, turn: OrientationConstraint | None, where: str
) -> list[JointGoal | LinkGoal]:
    if turn is not None and turn.link_name != place.link_name:
        raise SceneError(
            f"{where} has a position for link {shown(place.link_name)} and an orientation for link "
            f"{shown(turn.link_name)}, which is not supported; give both for one link."
        )
    if turn is None and any(place.target_point_offset):
        raise SceneError(
            f"{where} has a 'target_point_offset' and no orientation, which is not supported; add an orientation "
            "constraint, or name a link whose origin is that point."
        )
    region, frame = place.constraint_region, place.header.frame_id.removeprefix("/")
    turned = (None, "") if turn is None else (turn.orientation, turn.header.frame_id.removeprefix("/"))
    return [
        LinkGoal(place.link_name, each.position, frame, place.target_point_offset, *turned)
        for each in region.primitive_poses
    ]
