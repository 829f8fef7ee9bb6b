"""``plan.json``: the record that is written, whose types and docstrings are the schema of the file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from planner.base.progress import rounded
from planner.kinematics.manipulability import manipulability
from planner.models.run_record import run_record
from planner.paths.measure import corners
from planner.planning.lower_bound import cost_lower_bound
from planner.planning.manipulability_floor import first_violation
from planner.planning.network import PathCost
from planner.problem.reason_schema import ReasonRecord
from planner.problem.run_schema import Nodes, Record, RoadmapRecord, RunRecord
from planner.trajectory.clearance import Nearest

if TYPE_CHECKING:
    from planner.planning.result import Plan

_CORNERS = ("corners", "corners_blended", "shortcuts")  # what a trajectory's proof says of a path's corners


@dataclass(frozen=True, kw_only=True)
class PointRecord(Record):
    """The best cost after so many rounds."""

    rounds: int
    cost: float


@dataclass(frozen=True, kw_only=True)
class DipRecord(Record):
    """Whether w falls below both its ends along the path, and the floor that was set so that it does not."""

    below_both_ends: bool
    floor: float


@dataclass(frozen=True, kw_only=True)
class QualityRecord(Record):
    """How good the path is."""

    effort: int
    """rounds of refinement and search"""
    curve: list[PointRecord]
    lower_bound: float
    """no path costs less"""
    gap: float | None
    """how much more this one costs at most, as a share"""
    corners: int
    dip: DipRecord


@dataclass(frozen=True, kw_only=True)
class FloorRecord(Record):
    """What came of the manipulability floor that was asked for."""

    asked: float
    start: float
    """w at the start"""
    goal: float
    """w at the goal"""
    reached: bool
    holds: bool


@dataclass(frozen=True, kw_only=True)
class ManipulabilityRecord(Record):
    """Yoshikawa's w, sampled densely along the path."""

    min: float
    mean: float
    rows: str
    """rows of the Jacobian: pose, translation or planar"""
    frame: str
    floor: FloorRecord | None = None


@dataclass(frozen=True, kw_only=True)
class ClearanceRecord(Record):
    """How near path and motion come to anything that is checked."""

    path: Nearest | None
    """null where there is nothing to come near to"""
    motion: Nearest | None
    """null where there is no motion"""
    kept: float
    """m beyond the margin that every edge kept from which the path was chosen"""


@dataclass(frozen=True, kw_only=True)
class LengthRecord(Record):
    """How long the path is."""

    joint: float
    """rad"""
    workspace: float
    """of the tool's path, m"""


@dataclass(frozen=True, kw_only=True)
class MotionRecord(Record):
    """The trajectory beside it."""

    law: str
    duration: float
    """s"""
    limits: str
    corners: int | None = None
    corners_blended: int | None = None
    shortcuts: int | None = None
    proven: bool
    floor: dict[str, Any] | None


@dataclass(frozen=True, kw_only=True)
class CertificateRecord(Record):
    """A bound of the paper, or one of ours, beside the measured value; null where a number overflows."""

    name: str
    equation: str
    quantity: str
    bound: float | None
    measured: float | None
    slack: float | None
    assumptions: list[dict[str, Any]]
    ours: bool
    log10_remaining: float | None
    proven: bool
    earliest: float | None
    latest: float | None
    applies: bool
    holds: bool


@dataclass(frozen=True, kw_only=True)
class FieldRecord(Record):
    """How the dynamics settled."""

    law: str
    prescribed_time: float
    """T_p, s"""
    settling_time: float | None
    """s"""
    settling_tau: float | None
    settling_tau_bracket: list[float | None] | None
    """proved: earliest and latest, null where it was not found"""
    log10_remaining: float | None
    """log10 of T_p minus the settling time"""
    steps: int
    residual: float | None
    max_error_vs_oracle: float | None
    """relative, against Dijkstra's answer"""
    outcome: str
    certificate: list[CertificateRecord]


@dataclass(frozen=True, kw_only=True)
class WaypointTimesRecord(Record):
    """When each waypoint of the path is reached and left, s from the scene's time 0; what lies between is a wait."""

    arrivals: list[float]
    departures: list[float]


@dataclass(frozen=True, kw_only=True)
class HorizonRecord(Record):
    """Until when nothing can touch, whatever the obstacles with a speed limit do below it."""

    free_until: float | None
    """s; null: at no time"""
    speed_limits: dict[str, float]
    """m/s by obstacle"""


@dataclass(frozen=True, kw_only=True)
class InTimeRecord(Record):
    """How the motion keeps clear of obstacles that move."""

    moving: list[str]
    """obstacles along a known motion"""
    waypoints: WaypointTimesRecord | None
    """null where nothing moves along a known motion"""
    horizon: HorizonRecord | None
    """null where no obstacle has a speed limit"""


@dataclass(frozen=True, kw_only=True)
class PlanRecord(RunRecord):
    """What ``planner plan`` writes as plan.json; units rad, m and s."""

    reason: ReasonRecord | None
    """why there is no path"""
    path: list[list[float]]
    """joint waypoints, rad (m where a joint slides), start first"""
    path_nodes: Nodes
    """their indices in the roadmap"""
    goal: str | None
    """which of the goals is reached"""
    cost: PathCost | None
    quality: QualityRecord | None
    manipulability: ManipulabilityRecord | None
    conditioning: dict[str, Any] | None
    """where w is smallest, and what to try where it is bad"""
    path_length: LengthRecord | None
    clearance: ClearanceRecord | None
    trajectory: MotionRecord | None
    in_time: InTimeRecord | None
    """null where no obstacle moves or may move, or no motion is"""
    roadmap: RoadmapRecord
    gabf: FieldRecord | None
    timings_s: dict[str, float]
    files: dict[str, str] | None = None
    """SHA-256 of the files written beside this one"""


def record_of(plan: Plan) -> PlanRecord:
    """What there is to be written of a plan."""
    begun: dict[str, Any] = run_record(plan.request, plan.outcome, plan.robot, plan.scene)
    begun["message"] = plan.message
    reason: Any = None if plan.reason is None else plan.reason.to_dict()
    return PlanRecord(
        **begun,
        reason=reason,
        path=plan.path.tolist(),
        path_nodes=plan.path_nodes.tolist(),
        goal=plan.goal,
        cost=plan.cost,
        quality=_quality(plan),
        manipulability=_manipulability(plan),
        conditioning=None if plan.conditioning is None else plan.conditioning.to_dict(),
        path_length=_length(plan),
        clearance=plan.nearest,
        trajectory=_motion(plan),
        in_time=_in_time(plan),
        roadmap=RoadmapRecord(**plan.roadmap.record(plan.edges_removed)),
        gabf=_field(plan),
        timings_s=rounded(plan.timings),
    )


def _quality(plan: Plan) -> QualityRecord | None:
    if plan.cost is None:
        return None
    bound = cost_lower_bound(plan.roadmap, plan.robot, plan.request.objective)
    w = plan.w_along_path
    return QualityRecord(
        effort=plan.request.rounds,
        curve=[PointRecord(rounds=rounds, cost=cost) for rounds, cost in plan.curve],
        lower_bound=bound,
        gap=plan.cost.total / bound - 1.0 if bound > 0 else None,
        corners=corners(plan.path),
        dip=DipRecord(below_both_ends=bool(w.min() < (1.0 - 1e-9) * min(w[0], w[-1])), floor=plan.dip_floor),
    )


def _manipulability(plan: Plan) -> ManipulabilityRecord | None:
    if not plan.solved:
        return None
    found, robot = plan.measures, plan.robot
    return ManipulabilityRecord(
        min=found.w_min, mean=found.w_mean, rows=robot.manipulability, frame=robot.tool, floor=_floor(plan)
    )


def _floor(plan: Plan) -> FloorRecord | None:
    """None where none was asked for."""
    floor = plan.request.min_manipulability
    if floor <= 0:
        return None
    start, goal = (float(w) for w in manipulability(plan.robot, plan.path[[0, -1]]))
    holds = first_violation(plan.robot, plan.path, floor) is None
    return FloorRecord(asked=floor, start=start, goal=goal, reached=bool(plan.w_along_path.max() >= floor), holds=holds)


def _length(plan: Plan) -> LengthRecord | None:
    if not plan.solved:
        return None
    return LengthRecord(joint=plan.measures.joint_length, workspace=plan.measures.workspace_length)


def _motion(plan: Plan) -> MotionRecord | None:
    made = plan.trajectory
    if made is None:
        return None
    limits = "" if made.limits is None else made.limits.text()
    known = {key: made.proof[key] for key in _CORNERS if key in made.proof}
    floor = made.proof.get("floor")
    return MotionRecord(law=made.law, duration=made.duration, limits=limits, **known, proven=made.proven, floor=floor)


def _in_time(plan: Plan) -> InTimeRecord | None:
    scene, route, made = plan.scene, plan.route, plan.trajectory
    if made is None or not (scene.moving or scene.limited):
        return None
    horizon = made.proof.get("horizon")
    return InTimeRecord(
        moving=[item.name for item in scene.moving],
        waypoints=None
        if route is None
        else WaypointTimesRecord(arrivals=route.arrivals.tolist(), departures=route.departures.tolist()),
        horizon=None if horizon is None else HorizonRecord(**horizon),
    )


def _field(plan: Plan) -> FieldRecord | None:
    field = plan.cost_to_go
    if field is None:
        return None
    bracket = field.settling_tau_bracket
    return FieldRecord(
        law=plan.request.law,
        prescribed_time=plan.request.prescribed_time,
        settling_time=field.settling_time,
        settling_tau=field.settling_tau,
        settling_tau_bracket=None if bracket is None else [tau if math.isfinite(tau) else None for tau in bracket],
        log10_remaining=field.log10_remaining,
        steps=field.steps,
        residual=field.residual,
        max_error_vs_oracle=plan.max_error_vs_oracle,
        outcome=field.outcome.key,
        certificate=[CertificateRecord(**bound.to_dict()) for bound in plan.certificate],
    )
