"""MotionPlanRequest messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from planner.base.errors import SceneError, choices
from planner.base.notes import Note
from planner.base.yamlfile import parse_yaml, read_text, shown, validate
from planner.world.moveit.fields import notes_of
from planner.world.moveit.messages import (
    Constraints,
    JointConstraint,
    MotionPlanRequestMessage,
    OrientationConstraint,
    PositionConstraint,
)
from planner.world.moveit.objects import carried
from planner.world.shapes import Carried


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
    """What a request asks: a start by joint names, what is carried, goals of equal right, shares of the limits.

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


def read_motion_plan_request(path: Path) -> MotionPlanRequest:
    """The request at ``path``; :class:`SceneError` for what cannot be read, or a field that changes what is asked."""
    where = f"MotionPlanRequest {path}"
    data = parse_yaml(read_text(path, "MotionPlanRequest"), where)
    message = validate(MotionPlanRequestMessage, data, where, SceneError)
    start, notes = message.start_state, notes_of(message, where)
    factors = {
        "velocity": message.max_velocity_scaling_factor,
        "acceleration": message.max_acceleration_scaling_factor,
    }
    return MotionPlanRequest(
        where,
        start.joint_state.values(),
        tuple(
            goal for k, item in enumerate(message.goal_constraints) for goal in _goals(item, f"{where}: goal {k + 1}")
        ),
        message.group_name,
        carried(start.attached_collision_objects, where),
        not start.is_diff,
        {kind: factor if factor <= 1.0 else 1.0 for kind, factor in factors.items() if factor > 0.0},
        notes,
    )


def _goals(item: Constraints, where: str) -> list[JointGoal | LinkGoal]:
    """The goals that reach all constraints: one in joints, or one for each place of the region of a position."""
    joints, positions, turns = item.joint_constraints, item.position_constraints, item.orientation_constraints
    if joints and (positions or turns):
        raise SceneError(f"{where} constrains joints and a link at once, which is not supported; give one of the two.")
    if joints:
        return [_joint_goal(joints, where)]
    for what, found in (("position_constraints", positions), ("orientation_constraints", turns)):
        if len(found) > 1:
            raise SceneError(f"{where} has {len(found)} {what} to keep at once, which is not supported; give one.")
    if not positions or not positions[0].constraint_region.primitive_poses:
        raise SceneError(f"{where} has neither joint nor position constraints; add one of them.")
    return _link_goals(positions[0], turns[0] if turns else None, where)


def _joint_goal(joints: Sequence[JointConstraint], where: str) -> JointGoal:
    values = {each.joint_name: each.position for each in joints}
    if len(values) < len(joints):
        raise SceneError(f"{where} constrains a joint twice, one of {choices(values)}; give one constraint a joint.")
    return JointGoal(values, {each.joint_name: (each.tolerance_below, each.tolerance_above) for each in joints})


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
