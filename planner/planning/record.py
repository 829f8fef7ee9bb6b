"""``plan.json``: the record of a plan, its schema in types and docstrings, and its rows in a table."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np
from pydantic import Field

from planner.base.arrays import Floats
from planner.base.errors import choices
from planner.constraints.keeps import Keeps
from planner.cost.motion_cost import MotionCost
from planner.cost.scale import manipulability_cost
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.planning.conditioning import Conditioning
from planner.planning.run import FieldRecord, MotionRecord, RunRecord, cost_text, outward
from planner.problem.options import Metric
from planner.problem.outcome import Nodes, NoPath, Record, Rows
from planner.problem.request import Objective, PlanQuality
from planner.roadmap.roadmap import Roadmap, RoadmapRecord
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.search.manipulability_floor import first_violation
from planner.search.network import PathCost
from planner.tool_paths.followed import LegRecord, ToolPathRecord
from planner.trajectory.measure import (
    CLOSE,
    NOTHING_NEAR,
    TOO_CLOSE,
    TOO_CLOSE_TEXT,
    Nearest,
    PathMeasures,
    dense_path,
    nearest_text,
    path_manipulability,
)
from planner.trajectory.safe_intervals import TimedRoute
from planner.trajectory.trajectory import Trajectory

CONDITIONING = "conditioning"  # the row that is there only where it is bad
_NOTABLE = 0.02  # share of a cost
_ROUNDING = 1e-9  # %, of a cost that is a sum
_KEPT_APART = 1e-3  # s between two states of a motion at which conditions are measured


@dataclass(frozen=True, kw_only=True, eq=False)
class PointRecord(Record):
    """The best cost after so many rounds."""

    rounds: int
    cost: float


@dataclass(frozen=True, kw_only=True, eq=False)
class QualityRecord(Record):
    """How good the path is."""

    effort: int
    """rounds of refinement and search"""
    curve: list[PointRecord]
    lower_bound: float
    """no path between the roadmap's start and goal configurations costs less"""
    gap: float | None
    """how much more this one costs at most than the optimum between these, as a share"""
    manipulability_cost: float | None
    """Omega of the path in pieces of 0.01 rad, where ``cost`` has it by few states an edge; null if charged at nodes"""

    @classmethod
    def of(
        cls,
        quality: PlanQuality,
        roadmap: Roadmap,
        robot: Robot,
        path: Floats,
        total: float,
        curve: tuple[tuple[int, float], ...],
    ) -> Self:
        """The quality of a path (k, dof) of ``roadmap`` that costs ``total``."""
        bound, finely = cost_lower_bound(roadmap, robot, quality.objective), None
        if quality.charge == "edges":
            alone, states = replace(quality.objective, beta=0.0, floor=0.0), dense_path(path)
            cost = MotionCost(robot, roadmap.scale, alone, longest=np.inf, states=3).of_pieces
            finely = float(cost(states[:-1], states[1:]).sum())
        points = [PointRecord(rounds=rounds, cost=cost) for rounds, cost in curve]
        gap = total / bound - 1.0 if bound > 0 else None
        return cls(effort=quality.rounds, curve=points, lower_bound=bound, gap=gap, manipulability_cost=finely)

    def rows(self, cost: PathCost, in_time: bool) -> Rows:
        """The bound on the cost, and what the effort gained; ``in_time`` it is not the cost that decides."""
        rows, finely = [], self.manipulability_cost
        if finely is not None and cost.beta < 1.0 and finely > (1.0 + _NOTABLE) * cost.manipulability:
            more = f"{100 * (finely / cost.manipulability - 1.0):.1f} % more: w dips between states"
            rows.append(("integral", f"{finely:.4f} manipulability in pieces of 0.01 rad, {more}"))
        ends, apart = "between the roadmap's start and goal configurations", ""
        if self.gap is not None and not in_time:
            share = max(0.0, 100 * self.gap - _ROUNDING)
            apart = f"; this path is at most {outward(share, 1, up=True)} % above the optimum between them"
        rows.append(("bound", f"no path {ends} costs less than {outward(self.lower_bound, 4, up=False)}{apart}"))
        if len(self.curve) > 1:
            first, last = self.curve[0], self.curve[-1]
            text = f"{last.rounds} rounds took the best cost from {first.cost:.4f} to {last.cost:.4f}"
            rows.append(("effort", text))
        return rows


def cost_lower_bound(roadmap: Roadmap, robot: Robot, objective: Objective) -> float:
    """A lower bound on the cost, as the network of ``roadmap`` charges it, of every path from a start to a goal.

    Starts and goals are the roadmap's: of what is asked of the tool, other configurations may be nearer to each other.
    No path is shorter than the straight line between its ends, in joint space or (metric "workspace") from tool to
    tool. omega is nowhere below ``scale.zeta``: integrated over that length it costs so much at least. Charged at
    nodes, the goal's own omega is all that every path pays. The least of all pairs of a start and a goal counts.
    """
    starts, goals = roadmap.nodes[roadmap.starts], roadmap.nodes[roadmap.goals]
    distance = _straight(robot, starts, goals, objective.metric)
    distance /= roadmap.scale.joint_length if objective.metric == "joint" else roadmap.scale.tool_length
    moves = (robot.difference(starts[:, None], goals[None]) != 0).any(axis=2)
    if objective.charge == "edges":
        omega = roadmap.scale.zeta * distance
    else:
        name, w = objective.manipulability_cost, roadmap.manipulability[roadmap.goals]
        omega = np.broadcast_to(manipulability_cost(w, roadmap.scale, name), moves.shape)
    return float(np.where(moves, objective.total(omega, distance), 0.0).min())


def _straight(robot: Robot, starts: Floats, goals: Floats, metric: Metric) -> Floats:
    """(s, g) straight-line lengths, rad of joint motion or metres of the tool's."""
    if metric == "joint":
        return np.linalg.norm(robot.difference(starts[:, None], goals[None]), axis=2)
    here, there = (tool_positions(robot, q) for q in (starts, goals))
    return np.linalg.norm(here[:, None] - there[None], axis=2)


@dataclass(frozen=True, kw_only=True, eq=False)
class FloorRecord(Record):
    """Whether the path keeps to the manipulability floor that was asked for."""

    asked: float
    start: float
    """w at the start"""
    goal: float
    """w at the goal"""
    reached: bool
    holds: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class ManipulabilityRecord(Record):
    """Yoshikawa's w, sampled densely along the path."""

    min: float
    mean: float
    rows: str
    """rows of the Jacobian: pose, translation or planar"""
    frame: str
    floor: FloorRecord | None = None

    @classmethod
    def of(cls, robot: Robot, path: Floats, floor: float) -> Self:
        """w along a path (k, dof), and its ``floor`` where that is above 0."""
        w, record = path_manipulability(robot, path), None
        if floor > 0:
            start, goal = (float(end) for end in manipulability(robot, path[[0, -1]]))
            holds = first_violation(robot, path, floor) is None
            record = FloorRecord(asked=floor, start=start, goal=goal, reached=bool(w.max() >= floor), holds=holds)
        return cls(min=float(w.min()), mean=float(w.mean()), rows=robot.manipulability, frame=robot.tool, floor=record)

    @property
    def text(self) -> str:
        return f"min {self.min:.5f}, mean {self.mean:.5f} along the path{self._floor_text}"

    @property
    def _floor_text(self) -> str:
        if self.floor is None:
            return ""
        asked, ends = self.floor.asked, min(self.floor.start, self.floor.goal)
        if not self.floor.holds:
            return f"; NOT above the floor of {asked:g}"
        if not self.floor.reached:
            return f"; it never reaches the floor of {asked:g}, and stays above its lower end's {ends:.5f}"
        low = "" if ends >= asked else f" but for the stretches from and to its ends, of w {ends:.5f}"
        return f"; above the floor of {asked:g}{low}"


@dataclass(frozen=True, kw_only=True, eq=False)
class ClearanceRecord(Record):
    """The smallest distance (m) to anything that is checked, of pairs that a joint can move."""

    path: Nearest | None
    """null where there is nothing to come near to"""
    motion: Nearest | None
    """null where there is no motion"""
    kept: float
    """m beyond the margin that every edge kept from which the path was chosen"""

    def rows(self, asked: float) -> Rows:
        """The smallest distances, and what is ``kept`` where it is less than was ``asked`` for (m)."""
        if self.path is None:
            return [("clearance", NOTHING_NEAR)]
        text = f"{nearest_text(self.path)} at {100 * self.path.at:.0f} % of the path"
        if self.motion is not None:
            text += f"; {nearest_text(self.motion)} at {self.motion.at:.3f} s of the motion"
        if 0 < self.kept < asked:
            kept = f"{1000 * self.kept:.2g} of {1000 * asked:g} mm"
            text += f". Refined paths keep {kept}: start, goal or a passage leave no more"
        least = min(item.min for item in (self.path, self.motion) if item is not None)
        return [("clearance", text), *([(TOO_CLOSE, TOO_CLOSE_TEXT)] if least < CLOSE else [])]


@dataclass(frozen=True, kw_only=True, eq=False)
class LengthRecord(Record):
    """How long the path is."""

    joint: float
    """rad"""
    workspace: float
    """of the tool's path, m"""

    @classmethod
    def of(cls, measures: PathMeasures) -> Self:
        return cls(joint=measures.joint_length, workspace=measures.workspace_length)


@dataclass(frozen=True, kw_only=True, eq=False)
class KeptRecord(Record):
    """How far path and motion stay inside a condition that is kept all along."""

    condition: str
    """as --keep takes it"""
    unit: str
    """of the least it has to spare, negative where it is broken"""
    path: float
    """least to spare along the path, sampled densely"""
    path_proven: bool
    motion: float | None
    """and in motion; null where there is none"""
    motion_proven: bool | None

    @classmethod
    def all_of(cls, keeps: Keeps, path: Floats, made: Trajectory | None) -> list[Self]:
        """A record of each condition."""
        if not keeps or not len(path):
            return []
        on_path = keeps.along(dense_path(path), np.stack([path[:-1], np.diff(path, axis=0)], axis=1))
        in_motion = [None] * len(on_path)
        if made is not None:
            times = np.linspace(made.times[0], made.times[-1], int(made.duration / _KEPT_APART) + 2)
            in_motion = keeps.along(made.at(times), made.coefficients)
        return [
            cls(
                condition=kept.condition.text,
                unit=kept.condition.unit,
                path=kept.spare,
                path_proven=kept.proven,
                motion=None if moving is None else moving.spare,
                motion_proven=None if moving is None else moving.proven,
            )
            for kept, moving in zip(on_path, in_motion, strict=True)
        ]

    @property
    def text(self) -> str:
        def spare(value: float, proven: bool | None, where: str) -> str:
            return f"{value:.3g} {self.unit}{where}, {'proven' if proven else 'NOT proven'}"

        text = f"{self.condition}: {spare(self.path, self.path_proven, ' to spare along the path')}"
        return text if self.motion is None else f"{text}; {spare(self.motion, self.motion_proven, ' in motion')}"


@dataclass(frozen=True, kw_only=True, eq=False)
class WaypointTimesRecord(Record):
    """When each waypoint of the path is reached and left, s from the scene's time 0; what lies between is a wait."""

    arrivals: list[float]
    departures: list[float]


@dataclass(frozen=True, kw_only=True, eq=False)
class HorizonRecord(Record):
    """Until when nothing can touch, whatever the obstacles with a speed limit do below it."""

    free_until: float | None
    """s; null: at no time"""
    speed_limits: dict[str, float]
    """m/s by obstacle"""


@dataclass(frozen=True, kw_only=True, eq=False)
class InTimeRecord(Record):
    """How the motion keeps clear of obstacles that move."""

    moving: list[str]
    """obstacles along a known motion"""
    waypoints: WaypointTimesRecord | None
    """null where nothing moves along a known motion"""
    horizon: HorizonRecord | None
    """null where no obstacle has a speed limit"""

    @classmethod
    def of(cls, scene: Scene, made: Trajectory | None, route: TimedRoute | None) -> Self | None:
        if made is None or not (scene.moving or scene.limited):
            return None
        times, horizon = None, made.proof.get("horizon")
        if route is not None:
            times = WaypointTimesRecord(arrivals=route.arrivals.tolist(), departures=route.departures.tolist())
        moving = [item.name for item in scene.moving]
        return cls(moving=moving, waypoints=times, horizon=None if horizon is None else HorizonRecord(**horizon))

    def rows(self, proven: bool) -> Rows:
        """How the motion keeps clear of what moves, and until when what may move cannot touch."""
        rows = []
        if self.waypoints:
            waits = sum(self.waypoints.departures) - sum(self.waypoints.arrivals)
            stands = f"it stands {waits:.3f} s on the way" if waits > 0 else "it need not wait"
            clear = "proven clear" if proven else "NOT proven clear"
            rows.append(("known motions", f"{clear} of {choices(self.moving)}; {stands}"))
        if self.horizon:
            limits = choices(f"{name} below {limit:g} m/s" for name, limit in self.horizon.speed_limits.items())
            until = self.horizon.free_until
            when = "at any time" if until is None else f"before {until:.3f} s"
            rows.append(("horizon", f"no contact {when}, whatever these do: {limits}"))
        return rows


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanRecord(RunRecord):
    """What ``planner plan`` writes as plan.json; units rad, m and s."""

    reason: Annotated[NoPath, Field(discriminator="kind")] | None
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
    conditioning: Conditioning | None
    """where w is smallest, and what to try where it is bad"""
    path_length: LengthRecord | None
    clearance: ClearanceRecord | None
    trajectory: MotionRecord | None
    kept: list[KeptRecord]
    """what path and motion keep besides limits and clearance"""
    in_time: InTimeRecord | None
    """null where no obstacle moves or may move, or no motion is"""
    roadmap: RoadmapRecord
    gabf: FieldRecord | None
    tool_path: ToolPathRecord | None = None
    """of ``planner follow`` only"""
    legs: list[LegRecord] | None = None
    """lines of the tool from the start and to the goal, where --approach or --retreat ask for them"""

    @property
    def rows(self) -> Rows:
        rows, motion = [("roadmap", self.roadmap.text)], self.trajectory
        if self.cost is not None:
            rows += self._path_rows(self.cost)
        what = "path" if motion is None else "path and motion"
        if self.tool_path is not None:
            rows += self.tool_path.rows(what)
        rows += [(leg.leg, leg.text(what)) for leg in self.legs or ()]
        if motion is not None:
            rows.append(("motion", motion.text(bool(self.manipulability and self.manipulability.floor))))
        rows += [("kept", kept.text) for kept in self.kept]
        if self.in_time is not None and motion is not None:
            rows += self.in_time.rows(motion.proven)
        return rows + (self.gabf.rows if self.gabf else [])

    def _path_rows(self, cost: PathCost) -> Rows:
        assert self.quality is not None
        assert self.manipulability is not None
        assert self.clearance is not None
        assert self.path_length is not None
        rows = [("cost", cost_text(cost)), *self.quality.rows(cost, self.in_time is not None)]
        rows.append(("manipulability w", self.manipulability.text))
        if self.conditioning is not None and self.conditioning.advice:
            rows.append((CONDITIONING, self.conditioning.advice))
        rows += self.clearance.rows(self.config["room"])
        length = f"{self.path_length.joint:.3f} rad, {self.path_length.workspace:.3f} m"
        return [*rows, ("goal reached", self.goal or ""), ("path", f"{len(self.path)} waypoints, {length}")]
