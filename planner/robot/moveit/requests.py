"""MotionPlanRequest messages: start, goals, and the constraints on the path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pydantic

from planner.base.arrays import Floats
from planner.base.errors import choices
from planner.base.files import StrPath
from planner.base.notes import Note
from planner.base.yamlfile import Coordinate, Name, Number, parse_yaml, read_text
from planner.robot.moveit.messages import (
    Header,
    Message,
    PoseMessage,
    Quaternion,
    RobotState,
    Solid,
    Tolerance,
    Triple,
    read_message,
    require_fit,
)
from planner.robot.moveit.scenes import carried
from planner.robot.shapes import Carried

Solids = Sequence[tuple[str, tuple[float, ...], Floats]]
_SIZES = {"box": 3, "sphere": 1}  # the regions whose tolerance is followed


class Region(Solid):
    """A primitive as a tolerance: it may have no size."""

    dimensions: tuple[Tolerance, ...]

    @pydantic.model_validator(mode="after")
    def _around_its_origin(self) -> Region:
        if self.kind not in ("box", "sphere", "cylinder", "cone"):
            raise ValueError(f"a region of type '{self.kind}' is not supported; use box, sphere, cylinder or cone")
        if len(self.dimensions) != _SIZES.get(self.kind, len(self.dimensions)):
            raise ValueError(f"a {self.kind} has {_SIZES[self.kind]} dimensions, this one {len(self.dimensions)}")
        return self


class BoundingVolume(Message):
    primitives: tuple[Region, ...] = ()
    primitive_poses: tuple[PoseMessage, ...] = ()  # points where there are no primitives

    @pydantic.model_validator(mode="after")
    def _placed(self) -> BoundingVolume:
        if self.primitives:
            require_fit(self.primitives, self.primitive_poses, "primitive_poses", "primitives")
        return self

    def solids(self) -> Solids:
        """Alternatives: a kind of solid, its dimensions and its placement (4, 4)."""
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


class MotionPlanRequestMessage(Message):
    start_state: RobotState
    goal_constraints: list[Constraints] = pydantic.Field(min_length=1)
    path_constraints: Constraints = Constraints()
    group_name: Name = ""
    max_velocity_scaling_factor: Number = 0.0
    max_acceleration_scaling_factor: Number = 0.0


@dataclass(frozen=True)
class MotionPlanRequest:
    """A start by joint names, carried shapes, alternative goals, constraints on the path, shares of the limits.

    ``group`` is empty where the request names none. ``shares``, of velocity and of acceleration, are there where the
    request says one. A start that ``replaces`` the scene's is no difference to it.
    """

    where: str
    start: Mapping[str, float]
    goals: tuple[Constraints, ...]
    path: Constraints
    group: str
    carried: tuple[Carried, ...]
    replaces: bool
    shares: Mapping[str, float]
    notes: tuple[Note, ...]


def read_motion_plan_request(path: StrPath) -> MotionPlanRequest:
    """The request at ``path``; :class:`SceneError` for what cannot be read, or a field that changes what is asked."""
    path = Path(path)
    where = f"MotionPlanRequest {path}"
    data = parse_yaml(read_text(path, "MotionPlanRequest"), where)
    message, notes = read_message(MotionPlanRequestMessage, data, where)
    start = message.start_state
    factors = {kind: getattr(message, f"max_{kind}_scaling_factor") for kind in ("velocity", "acceleration")}
    if wrong := [f"max_{kind}_scaling_factor" for kind, factor in factors.items() if not 0.0 <= factor <= 1.0]:
        notes += (Note(f"{where}: {choices(wrong)} outside (0, 1] is taken as 1, as MoveIt does."),)
    return MotionPlanRequest(
        where,
        start.joint_state.values(),
        tuple(message.goal_constraints),
        message.path_constraints,
        message.group_name,
        carried(start.attached_collision_objects, where),
        not start.is_diff,
        {kind: min(factor, 1.0) for kind, factor in factors.items() if factor > 0.0},
        notes + _note_on_tolerances(message, where),
    )


def _note_on_tolerances(message: MotionPlanRequestMessage, where: str) -> tuple[Note, ...]:
    """A note where a goal is the centre of its tolerances, or tolerances are followed by simpler ones inside them."""
    places = list[str]()
    for k, item in enumerate((message.path_constraints, *message.goal_constraints)):
        solids = [solid for each in item.position_constraints for solid in each.constraint_region.primitives]
        joints = any(each.tolerance_above or each.tolerance_below for each in item.joint_constraints)
        turns = any(any(each.tolerances) for each in item.orientation_constraints)
        if (k and joints) or turns or any(each.kind != "box" and any(each.dimensions) for each in solids):
            places.append(f"goal {k}" if k else "path_constraints")
    text = f"{where}: of tolerances that are no box a simpler part inside them is followed: {choices(places)}."
    return (Note(text, grave=False),) if places else ()
