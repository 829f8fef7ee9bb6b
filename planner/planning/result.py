"""A plan with everything it was made from, and its files: plan.json, plan.html, roadmap.npz and trajectory.json."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.files import StrPath, staged, write_json
from planner.base.html import html_table
from planner.base.progress import Stopwatch, rounded
from planner.certificate.certificate import PROOF_NAME, Certificate, certificate_of
from planner.collision.checker import CollisionChecker
from planner.cost.motion_cost import MotionCost
from planner.kinematics.manipulability import manipulability
from planner.planning.conditioning import Conditioning, judge_conditioning
from planner.planning.followed import FollowedPath, leg_line
from planner.planning.lower_bound import cost_lower_bound
from planner.planning.record import (
    CertificateRecord,
    ClearanceRecord,
    FieldRecord,
    FloorRecord,
    HorizonRecord,
    InTimeRecord,
    KeptRecord,
    LegRecord,
    LengthRecord,
    ManipulabilityRecord,
    MotionRecord,
    PlanRecord,
    PointRecord,
    QualityRecord,
    WaypointTimesRecord,
)
from planner.planning.replanned import Edges, Replanned
from planner.planning.run_record import run_record
from planner.planning.summary import CONDITIONING, summary_rows
from planner.problem.outcome import Outcome
from planner.problem.reasons import NoPath
from planner.problem.request import FollowRequest, PlanRequest, SweepQuality, TaskQuality
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import save_roadmap
from planner.robot import model_checks
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.search.manipulability_floor import LayeredNetwork, first_violation
from planner.search.network import PathCost
from planner.trajectory.clearance import nearest_in_motion, nearest_on_path
from planner.trajectory.file import TRAJECTORY_NAME, save_trajectory
from planner.trajectory.measure import PathMeasures, corners, dense_path, measure_path, path_manipulability
from planner.trajectory.path_clearance import TOO_CLOSE
from planner.trajectory.trajectory import Trajectory
from planner.view.page import Content, page, save_page
from planner.view.shown_path import ShownPath, path_rows, shown_motion

if TYPE_CHECKING:
    from planner.trajectory.safe_intervals import TimedRoute

_CORNERS = ("corners", "corners_blended", "shortcuts")  # what a trajectory's proof says of a path's corners
_KEPT_APART = 1e-3  # s between two looks at what is kept in motion
JSON_NAME, PAGE_NAME, ROADMAP_NAME = "plan.json", "plan.html", "roadmap.npz"
NAMES = (ROADMAP_NAME, TRAJECTORY_NAME, PROOF_NAME, PAGE_NAME, JSON_NAME)  # the record last


@dataclass(frozen=True, eq=False)
class Plan:
    """A plan with everything it was made from; ``path`` (k, dof) and ``path_nodes`` are empty where there is none.

    A continuous joint is unwound along the path, so that following it is never a jump. ``layered`` is what the dynamics
    ran on, where it came so far: the roadmap, or with a manipulability floor the layers of
    :mod:`planner.search.manipulability_floor`; ``cost_to_go`` is of its nodes. ``goal`` is the text of the goal
    that is reached, ``alternatives`` the paths of other betas, see :mod:`planner.tradeoff.alternatives`. ``reason``
    says why there is no path. Of a session ``path_nodes`` are nodes of its whole roadmap, whose edges may be open.
    """

    request: PlanRequest | FollowRequest
    outcome: Outcome
    robot: Robot
    scene: Scene
    checker: CollisionChecker
    roadmap: Roadmap
    layered: LayeredNetwork | None = None
    cost_to_go: gabf.CostToGo | None = None
    path: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    path_nodes: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    goal: str | None = None  # the text of the goal that the path reaches
    cost: PathCost | None = None
    curve: tuple[tuple[int, float], ...] = ()  # (rounds of effort, best cost)
    clearance_kept: float = 0.0  # m beyond the margin, by all edges that the path was chosen from
    edges_removed: int = 0
    trajectory: Trajectory | None = None  # along the path, where one was asked for
    route: TimedRoute | None = None  # when each waypoint is reached and left, where obstacles move
    alternatives: tuple[ShownPath, ...] = ()
    tool_path: FollowedPath | None = None  # what came of a tool path that was to be followed
    legs: tuple[LegRecord, ...] = ()  # lines of the tool that the path begins and ends with, where they were asked for
    reason: NoPath | None = None
    end_notes: tuple[str, ...] = ()  # on the start
    replanned: Replanned = field(default_factory=Replanned)
    timings: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        size = f"{len(self.path)} waypoints" if len(self.path) else "no path"
        return f"<Plan: {self.robot.name} in {self.scene.name}, {self.outcome.key}, {size}>"

    @property
    def notes(self) -> tuple[str, ...]:
        """What was noticed about robot, scene and start, as ``plan.json`` has it."""
        return (*(note.text for note in model_checks.notes(self.robot, self.scene)), *self.end_notes)

    @property
    def message(self) -> str:
        """How the plan ended, in one sentence: without a path the reason, as far as it is known."""
        return self.outcome.value if self.reason is None else self.reason.sentence

    @property
    def solved(self) -> bool:
        """Whether there is a path."""
        return self.outcome is Outcome.SOLVED

    @property
    def seconds(self) -> float:
        """How long it took, all stages together."""
        return sum(self.timings.values())

    @property
    def edges(self) -> Edges:
        """What became of a session's edges for this plan; all 0 where it is no session's."""
        return self.replanned.edges

    @cached_property
    def measures(self) -> PathMeasures:
        """Manipulability and lengths along the path, where there is one."""
        return measure_path(self.robot, self.path)

    @cached_property
    def w_along_path(self) -> Floats:
        """w (n,) sampled densely along the path, where there is one."""
        return path_manipulability(self.robot, self.path)

    @cached_property
    def cost_in_pieces(self) -> float | None:
        """Omega of the path in pieces of 0.01 rad, where edges are priced by few states; None if charged at nodes."""
        objective = replace(self.request.quality.objective, beta=0.0, floor=0.0)
        if objective.charge == "nodes":
            return None
        states = dense_path(self.path)
        cost = MotionCost(self.robot, self.roadmap.scale, objective, longest=np.inf, states=3).of_pieces
        return float(cost(states[:-1], states[1:]).sum())

    @cached_property
    def conditioning(self) -> Conditioning | None:
        """How well conditioned the path is where that is worst; None where there is none."""
        return judge_conditioning(self.robot, self.roadmap, self.path, self.request.quality) if len(self.path) else None

    @cached_property
    def max_error_vs_oracle(self) -> float | None:
        """The largest error of the cost-to-go against Dijkstra's answer, relative to max(1, |x*|); None without one."""
        field = self.cost_to_go
        return None if field is None else gabf.max_error(field, gabf.oracle(field.network))

    @cached_property
    def certificate(self) -> tuple[gabf.Certificate, ...]:
        """Every bound of the paper that the last run of the dynamics meets."""
        field = self.cost_to_go
        return () if field is None else tuple(gabf.certify(field.network, field.law, field))

    @cached_property
    def nearest(self) -> ClearanceRecord | None:
        """How near path and motion come to anything that is checked, and what refined paths ``kept``, m."""
        if not len(self.path):
            return None
        motion = None if self.trajectory is None else nearest_in_motion(self.trajectory, self.checker)
        return ClearanceRecord(path=nearest_on_path(self.path, self.checker), motion=motion, kept=self.clearance_kept)

    @property
    def clearance(self) -> dict[str, Any] | None:
        """``nearest`` as ``plan.json`` has it; None where there is no path."""
        return None if self.nearest is None else self.nearest.to_dict()

    @property
    def node_costs(self) -> Floats | None:
        """The cost-to-go (n,) of the roadmap's nodes, where it came so far; inf for those that came after the field."""
        if self.layered is None or self.cost_to_go is None:
            return None
        x = self.layered.on_roadmap(self.cost_to_go.x)
        return np.concatenate([x, np.full(len(self.roadmap.nodes) - len(x), np.inf)])

    @property
    def network(self) -> gabf.Network | None:
        """The network of ``layered``."""
        return None if self.layered is None else self.layered.network

    def _repr_html_(self) -> str:
        caption = f"{self.robot.name} in {self.scene.name}. {self.message}"
        return html_table(caption, summary_rows(plan_record(self)))

    def to_dict(self) -> dict[str, Any]:
        """The keys of ``plan.json``; units in rad, m and s."""
        return plan_record(self)

    def page(self) -> str:
        """The page as HTML text that needs nothing but a browser; it draws what is there and computes nothing."""
        return plan_page(self)

    def certify(self) -> Certificate | None:
        """The plan with its proof, for a checker that believes nobody; None where there is no path.

        Not to be confused with ``certificate``, which is of the field's settling.
        """
        if not self.solved:
            return None
        return certificate_of(self.checker, self.path, self.trajectory, self.request.quality.min_manipulability)

    def save(self, folder: StrPath, certificate: bool = False) -> None:
        """Write ``plan.json``, ``plan.html`` and ``roadmap.npz`` under ``folder``, which is made if it does not exist.

        With a trajectory also ``trajectory.json``, with ``certificate`` also ``proof.npz`` where there is a path.
        Raises :class:`FileError` where that cannot be done.
        """
        save_plan(self, Path(folder), certificate=certificate)


def plan_record(plan: Plan) -> dict[str, Any]:
    """The plan as plain data, the keys of ``plan.json``; units in rad, m and s."""
    return record_of(plan).to_dict()


def save_plan(plan: Plan, folder: Path, clock: Stopwatch | None = None, certificate: bool = False) -> dict[str, Any]:
    """Write the files; the stages of ``clock`` go with the plan's own. Returns the record that was written."""
    clock = clock or Stopwatch(plan.timings)
    return save_plan_page(plan, folder, save_plan_without_page(plan, folder, clock, certificate), clock)


def save_plan_without_page(
    plan: Plan, folder: Path, clock: Stopwatch | None = None, certificate: bool = False
) -> dict[str, Any]:
    """Write all but the page, take what an earlier plan left of the rest away, and return the record.

    The record is renamed last.
    """
    clock = clock or Stopwatch(plan.timings)
    clock.seconds.update(plan.timings)
    with staged(folder, NAMES) as inner:
        with clock("files"):
            save_parts(inner, plan.roadmap, plan.trajectory, plan.robot.name, plan.scene.name)
        if certificate:
            with clock("certificate"):
                proof = plan.certify()
                if proof is not None:
                    proof.save(inner / PROOF_NAME)
        with clock("settling"):
            plan.certificate  # noqa: B018 (kept)
        with clock("record"):
            record = plan_record(plan)
        record["timings_s"] = clock.record()
        write_json(inner / JSON_NAME, record)
    return record


def save_parts(folder: Path, roadmap: Roadmap | None, motion: Trajectory | None, robot: str, scene: str) -> None:
    """Write ``roadmap.npz`` and ``trajectory.json`` into an empty ``folder``, as far as there are such."""
    if roadmap is not None:
        save_roadmap(roadmap, folder / ROADMAP_NAME)
    if motion is not None:
        save_trajectory(motion, folder / TRAJECTORY_NAME, robot, scene)


def save_plan_page(plan: Plan, folder: Path, record: dict[str, Any], clock: Stopwatch) -> dict[str, Any]:
    """Write ``plan.html``, and the record again with its hash and the seconds of ``clock``."""
    return save_page(lambda: plan_page(plan), folder / PAGE_NAME, record, folder / JSON_NAME, clock)


def plan_page(plan: Plan) -> str:
    """A plan's page as HTML text; without a path the roadmap shows where it stops."""
    paths, current = shown_paths(plan)
    content = Content(
        plan.robot,
        plan.scene,
        plan.message,
        plan.roadmap.nodes[plan.roadmap.starts[0]],
        details=summary_rows(plan_record(plan)),
        roadmap=plan.roadmap,
        cost_to_go=plan.node_costs,
        paths=paths,
        current=current,
        beta=plan.request.quality.beta,
        floor=plan.request.quality.min_manipulability,
        curve=plan.curve,
        highlighted=(CONDITIONING, TOO_CLOSE),
        reason=plan.reason,
        tool_lines=_tool_lines(plan),
        rungs=None if plan.tool_path is None else plan.tool_path.rungs,
    )
    return page(content)


def _tool_lines(plan: Plan) -> list[tuple[Floats, float]]:
    """What the tool was to follow, each line with the radius of its tube (m)."""
    ends = {"retreat": 0, "approach": -1}
    lines = [(leg_line(plan.robot, plan.path[ends[leg.leg]], leg.length), leg.tube.position) for leg in plan.legs]
    if plan.tool_path is not None:
        lines.append((plan.tool_path.wanted, plan.tool_path.record.tube.position))
    return lines


def shown_paths(plan: Plan) -> tuple[list[ShownPath], int]:
    """The alternatives with the plan's own path among them, and which it is; none without a path."""
    if plan.cost is None:
        return [], 0
    beta, shown, costs = (
        plan.request.quality.beta,
        list(plan.alternatives),
        (plan.cost.manipulability, plan.cost.distance),
    )
    rows, field = path_rows(plan.robot, plan.path, *costs), plan.node_costs
    motion = None if plan.trajectory is None else shown_motion(plan.trajectory, plan.checker)
    if plan.scene.moving:  # the earliest motion, which no beta has chosen
        return [ShownPath(plan.path, rows, cost_to_go=field, motion=motion)], 0
    for k, other in enumerate(shown):
        assert other.interval is not None
        assert other.costs is not None
        if np.isclose(other.costs, costs, rtol=1e-9).all() and other.interval[0] <= beta <= other.interval[1]:
            shown[k] = ShownPath(plan.path, rows, other.interval, field, costs, motion)
            return shown, k
    # as good as the others at this one beta, as may be at 0, at 1 and where two intervals meet
    place = sum(other.interval is not None and other.interval[0] < beta for other in shown)
    shown.insert(place, ShownPath(plan.path, rows, (beta, beta), field, costs, motion))
    return shown, place


def record_of(plan: Plan) -> PlanRecord:
    """What there is to be written of a plan."""
    begun: dict[str, Any] = run_record(plan.request, plan.outcome, plan.robot, plan.scene)
    begun |= {"message": plan.message, "notes": list(plan.notes)}
    return PlanRecord(
        **begun,
        reason=plan.reason,
        path=plan.path.tolist(),
        path_nodes=plan.path_nodes.tolist(),
        goal=plan.goal,
        cost=plan.cost,
        quality=_quality(plan),
        manipulability=_manipulability(plan),
        conditioning=None if plan.conditioning is None else plan.conditioning.to_dict(),
        path_length=_length(plan),
        clearance=plan.nearest,
        trajectory=motion_record(plan.trajectory, plan.robot),
        kept=_kept(plan),
        in_time=_in_time(plan),
        roadmap=plan.roadmap.record(plan.edges_removed),
        gabf=field_record(plan.request.quality, plan.cost_to_go, plan.certificate, plan.max_error_vs_oracle),
        timings_s=rounded(plan.timings),
        tool_path=None if plan.tool_path is None else plan.tool_path.record,
        legs=list(plan.legs) or None,
    )


def _quality(plan: Plan) -> QualityRecord | None:
    if plan.cost is None:
        return None
    bound = cost_lower_bound(plan.roadmap, plan.robot, plan.request.quality.objective)
    return QualityRecord(
        effort=plan.request.quality.rounds,
        curve=[PointRecord(rounds=rounds, cost=cost) for rounds, cost in plan.curve],
        lower_bound=bound,
        gap=plan.cost.total / bound - 1.0 if bound > 0 else None,
        manipulability_cost=plan.cost_in_pieces,
        corners=corners(plan.path),
    )


def _manipulability(plan: Plan) -> ManipulabilityRecord | None:
    if not len(plan.path):
        return None
    found, robot = plan.measures, plan.robot
    return ManipulabilityRecord(
        min=found.w_min, mean=found.w_mean, rows=robot.manipulability, frame=robot.tool, floor=_floor(plan)
    )


def _floor(plan: Plan) -> FloorRecord | None:
    """None where none was asked for."""
    floor = plan.request.quality.min_manipulability
    if floor <= 0:
        return None
    start, goal = (float(w) for w in manipulability(plan.robot, plan.path[[0, -1]]))
    holds = first_violation(plan.robot, plan.path, floor) is None
    return FloorRecord(asked=floor, start=start, goal=goal, reached=bool(plan.w_along_path.max() >= floor), holds=holds)


def _length(plan: Plan) -> LengthRecord | None:
    if not len(plan.path):
        return None
    return LengthRecord(joint=plan.measures.joint_length, workspace=plan.measures.workspace_length)


def motion_record(made: Trajectory | None, robot: Robot) -> MotionRecord | None:
    """What there is to be written of a motion."""
    if made is None:
        return None
    limits = "" if made.limits is None else made.limits.text(robot)
    known = {key: made.proof[key] for key in _CORNERS if key in made.proof}
    floor = made.proof.get("floor")
    return MotionRecord(law=made.law, duration=made.duration, limits=limits, **known, proven=made.proven, floor=floor)


def _kept(plan: Plan) -> list[KeptRecord]:
    keeps, made = plan.checker.world.keeps, plan.trajectory
    if not plan.solved or not keeps:
        return []
    path = keeps.along(dense_path(plan.path), np.stack([plan.path[:-1], np.diff(plan.path, axis=0)], axis=1))
    motion = None if made is None else keeps.along(made.at(_kept_times(made)), made.coefficients)
    return [
        KeptRecord(
            condition=on_path.condition.text,
            unit=on_path.condition.unit,
            path=on_path.spare,
            path_proven=on_path.proven,
            motion=None if motion is None else motion[k].spare,
            motion_proven=None if motion is None else motion[k].proven,
        )
        for k, on_path in enumerate(path)
    ]


def _kept_times(made: Trajectory) -> Floats:
    return np.linspace(made.times[0], made.times[-1], int(made.duration / _KEPT_APART) + 2)


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


def field_record(
    quality: SweepQuality | TaskQuality,
    field: gabf.CostToGo | None,
    bounds: Iterable[gabf.Certificate],
    error: float | None,
) -> FieldRecord | None:
    """What there is to be written of a field with the ``bounds`` that it meets, and its error against the oracle."""
    if field is None:
        return None
    bracket = field.settling_tau_bracket
    return FieldRecord(
        law=quality.law,
        prescribed_time=quality.prescribed_time,
        settling_time=field.settling_time,
        settling_tau=field.settling_tau,
        settling_tau_bracket=None if bracket is None else [tau if math.isfinite(tau) else None for tau in bracket],
        log10_remaining=field.log10_remaining,
        steps=field.steps,
        residual=field.residual,
        max_error_vs_oracle=error,
        outcome=field.outcome.key,
        certificate=[CertificateRecord(**bound.to_dict()) for bound in bounds],
    )
