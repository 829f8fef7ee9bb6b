"""MotionPlanRequest messages: constraints, the request, and what we take from it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import pydantic

from planner.base.arrays import Floats
from planner.base.errors import SceneError, choices
from planner.base.files import StrPath
from planner.base.notes import Note
from planner.base.yamlfile import Coordinate, Name, Number, Strict, Whole, parse_yaml, read_text, validate
from planner.models.files.moveit.fields import Label, Noted, Refused, none, notes_of
from planner.models.files.moveit.messages import (
    Header,
    MeshMessage,
    PoseMessage,
    PoseStamped,
    Quaternion,
    RobotState,
    Solid,
    Text,
    Triple,
    fits,
)
from planner.models.files.moveit.objects import carried
from planner.models.poses import pose
from planner.models.shapes import Carried

_FINE = 0.01  # rad (m): a goal whose tolerances are no larger is reached at their centre
_Tolerance = Annotated[Number, pydantic.Field(ge=0)]
_KNOWN_FACTORS = (0.0, 1.0)
_Weight = Annotated[
    Number, Noted("all constraints are kept, whatever their weights", when=lambda value: value not in _KNOWN_FACTORS)
]
_SETTINGS = Noted("passed over, as only MoveIt's own planners or a moving base need it")
_LATER = "is not kept by this planner: take it out, and look at the motion that is planned without it"


class _Region(Solid):
    """A primitive as a tolerance: it may have no size."""

    dimensions: list[Annotated[Number, pydantic.Field(ge=0)]]

    @pydantic.model_validator(mode="after")
    def _around_its_origin(self) -> _Region:
        if self.kind not in ("box", "sphere", "cylinder", "cone"):
            raise ValueError(f"a goal region of type '{self.kind}' is not supported; use box, sphere, cylinder or cone")
        if len(self.dimensions) != _SIZES.get(self.kind, len(self.dimensions)):
            raise ValueError(f"a {self.kind} has {_SIZES[self.kind]} dimensions, this one {len(self.dimensions)}")
        return self


_SIZES = {"box": 3, "sphere": 1}  # those whose tolerance is honoured


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
        if self.mesh_poses:
            fits(self.meshes, self.mesh_poses, "mesh_poses", "meshes")
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
    parameterization: Literal[0, 1] = 0  # angles about x, y and z, or a rotation vector
    weight: _Weight = 0.0

    @pydantic.model_validator(mode="after")
    def _turned(self) -> OrientationConstraint:
        self.matrix()
        return self

    def matrix(self) -> Floats:
        return pose(quaternion=self.orientation)

    @property
    def tolerances(self) -> tuple[float, float, float]:
        return self.absolute_x_axis_tolerance, self.absolute_y_axis_tolerance, self.absolute_z_axis_tolerance


class VisibilityConstraint(Strict):
    target_radius: Number = 0.0
    target_pose: PoseStamped = PoseStamped()
    cone_sides: Whole = 0
    sensor_pose: PoseStamped = PoseStamped()
    max_view_angle: Number = 0.0
    max_range_angle: Number = 0.0
    sensor_view_direction: Whole = 0
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
    Number,
    Noted("outside (0, 1], and taken as 1, as MoveIt does", when=lambda value: not 0.0 <= value <= 1.0, grave=True),
]


class MotionPlanRequestMessage(Strict):
    workspace_parameters: Annotated[WorkspaceParameters, _SETTINGS] = WorkspaceParameters()
    start_state: RobotState
    goal_constraints: list[Constraints] = pydantic.Field(min_length=1)
    path_constraints: Constraints = Constraints()
    trajectory_constraints: Annotated[
        TrajectoryConstraints, Refused(_LATER, when=lambda value: not all(each.empty for each in value.constraints))
    ] = TrajectoryConstraints()
    reference_trajectories: Annotated[list[GenericTrajectory], _SETTINGS] = none()
    pipeline_id: Annotated[Name, _SETTINGS] = ""
    planner_id: Annotated[Name, _SETTINGS] = ""
    group_name: Name = ""
    num_planning_attempts: Annotated[Whole, _SETTINGS] = 0
    allowed_planning_time: Annotated[Number, _SETTINGS] = 0.0
    max_velocity_scaling_factor: _Factor = 0.0
    max_acceleration_scaling_factor: _Factor = 0.0
    cartesian_speed_limited_link: Text = ""
    cartesian_speed_end_effector_link: Text = ""  # as it was called at first
    max_cartesian_speed: Annotated[
        Number,
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
class RegionGoal:
    """All that meets position and orientation constraints, with their tolerances."""

    places: tuple[Place, ...]
    turns: tuple[OrientationConstraint, ...]


@dataclass(frozen=True)
class Place:
    """A position constraint with one region: the point ``offset`` of ``link`` in a solid, None for its centre.

    ``placement`` (4, 4) is that of the solid in ``frame``.
    """

    link: str
    frame: str
    offset: tuple[float, float, float]
    placement: Floats
    kind: str
    dimensions: tuple[float, ...]


@dataclass(frozen=True)
class MotionPlanRequest:
    """What a request asks: a start by joint names, what is carried, alternative goals, shares of the limits.

    ``group`` is empty where the request names none. ``shares``, of velocity and of acceleration, are there where the
    request says one. A start that ``replaces`` the scene's is no difference to it. ``path`` is what links are to keep,
    and ``path_joints`` what joints are.
    """

    where: str
    start: Mapping[str, float]
    goals: tuple[JointGoal | LinkGoal | RegionGoal, ...]
    group: str
    carried: tuple[Carried, ...]
    replaces: bool
    shares: Mapping[str, float]
    notes: tuple[Note, ...]
    path: RegionGoal
    path_joints: tuple[JointConstraint, ...]


def read_motion_plan_request(path: StrPath) -> MotionPlanRequest:
    """The request at ``path``; :class:`SceneError` for what cannot be read, or a field that changes what is asked."""
    path = Path(path)
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
        (*notes, *_centred(message.goal_constraints, where)),
        _kept(message.path_constraints, f"{where}: path_constraints"),
        tuple(message.path_constraints.joint_constraints),
    )


def _kept(item: Constraints, where: str) -> RegionGoal:
    """What is to be kept on the way, of links."""
    places = []
    for each in item.position_constraints:
        found = _places(each)
        if len(found) != 1 or found[0].kind not in _SIZES:
            raise SceneError(
                f"{where} has a position constraint on a region that is no single box or sphere, which is not "
                "supported: give one of these."
            )
        places += found
    return RegionGoal(tuple(places), tuple(item.orientation_constraints))


def _places(item: PositionConstraint) -> list[Place]:
    """The alternatives of a position constraint."""
    region, frame = item.constraint_region, item.header.frame_id.removeprefix("/")
    solids: list[_Region | None] = list(region.primitives) or [None] * len(region.primitive_poses)
    return [
        Place(
            item.link_name,
            frame,
            item.target_point_offset,
            each.matrix(),
            *(("point", ()) if solid is None else (solid.kind, tuple(solid.dimensions))),
        )
        for solid, each in zip(solids, region.primitive_poses, strict=True)
    ]


def _centred(items: list[Constraints], where: str) -> tuple[Note, ...]:
    """A note where tolerances of goals are passed over, as goals are reached at their centre."""
    joints = any(each.tolerance_above or each.tolerance_below for item in items for each in item.joint_constraints)
    links = any(
        any(solid.dimensions) and (solid.kind not in _SIZES or not _is_wide(item))
        for item in items
        for each in item.position_constraints
        for solid in each.constraint_region.primitives
    ) or any(any(each.tolerances) and not _is_wide(item) for item in items for each in item.orientation_constraints)
    if not (joints or links):
        return ()
    of = " and ".join(name for name, said in (("joints", joints), ("links", links)) if said)
    return (Note(f"{where}: goals are reached at the centre of their tolerances, here of {of}.", grave=False),)


def _is_wide(item: Constraints) -> bool:
    """Whether a goal of links has tolerances, or is of a kind, that a pose would not do for."""
    places, turns = item.position_constraints, item.orientation_constraints
    if (len(places), len(turns)) not in ((1, 0), (1, 1)):
        return True
    region = places[0].constraint_region
    sizes = [solid.dimensions for solid in region.primitives if solid.kind in _SIZES]
    offset = not turns and any(places[0].target_point_offset)
    two = bool(turns) and turns[0].link_name != places[0].link_name
    widths = [*(max(size, default=0.0) for size in sizes), *(max(turn.tolerances) for turn in turns)]
    return offset or two or max(widths, default=0.0) > _FINE


def _goals(item: Constraints, where: str) -> Sequence[JointGoal | LinkGoal | RegionGoal]:
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
    regions = [_places(each) for each in positions]
    if not (turns or any(regions)) or not all(regions):
        raise SceneError(f"{where} has neither joint nor position nor orientation constraints; add one of them.")
    if _is_wide(item):
        return [RegionGoal(places, tuple(turns)) for places in itertools.product(*regions)]
    return _link_goals(positions[0], turns[0] if turns else None)


def _link_goals(place: PositionConstraint, turn: OrientationConstraint | None) -> list[LinkGoal]:
    region, frame = place.constraint_region, place.header.frame_id.removeprefix("/")
    turned = (None, "") if turn is None else (turn.orientation, turn.header.frame_id.removeprefix("/"))
    return [
        LinkGoal(place.link_name, each.position, frame, place.target_point_offset, *turned)
        for each in region.primitive_poses
    ]
