"""``plan.json``: the record of a plan; types and docstrings are its schema, ``rows`` its table."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field

from planner.base.arrays import Floats
from planner.base.errors import choices
from planner.constraints.path_constraints import PathConstraints
from planner.planning.base_result import FieldRecord, MotionRecord, RunRecord, cost_text
from planner.planning.quality import Conditioning, ManipulabilityRecord, QualityRecord
from planner.problem.outcome import Nodes, NoPath, Record, Rows
from planner.roadmap.roadmap import RoadmapRecord
from planner.robot.scene import Scene
from planner.search.network import PathCost
from planner.tool_paths.tool_motion import LegRecord, ToolPathRecord
from planner.trajectory.measure import CLOSE, NOTHING_NEAR, TOO_CLOSE, TOO_CLOSE_TEXT, Nearest, dense_path, nearest_text
from planner.trajectory.parts import busy_seconds
from planner.trajectory.safe_intervals import TimedRoute
from planner.trajectory.trajectory import Trajectory

CONDITIONING = "conditioning"  # row of a badly conditioned path
_SAMPLE_PERIOD = 1e-3  # s between states of a motion at which constraints are measured


@dataclass(frozen=True, kw_only=True, eq=False)
class ClearanceRecord(Record):
    """Smallest distances (m) of all checked pairs that a joint can move."""

    path: Nearest | None
    """null if the scene has no obstacle and the robot no self-pair"""
    motion: Nearest | None
    """null without a motion"""
    kept: float
    """m beyond the margin that all edges of the network keep"""

    def rows(self, requested: float) -> Rows:
        """Return rows for the distances, and for ``kept`` if it is less than ``requested`` (m)."""
        if self.path is None:
            return [("clearance", NOTHING_NEAR)]
        text = f"{nearest_text(self.path)} at {100 * self.path.at:.0f} % of the path"
        if self.motion is not None:
            text += f"; {nearest_text(self.motion)} at {self.motion.at:.3f} s of the motion"
        if 0 < self.kept < requested:
            kept = f"{1000 * self.kept:.2g} of {1000 * requested:g} mm"
            text += f". Refined paths keep {kept}: start, goal or a passage allow no more"
        return [("clearance", text), *([(TOO_CLOSE, TOO_CLOSE_TEXT)] if self.is_close else [])]

    @property
    def least(self) -> Nearest | None:
        """The smaller distance of path and motion; None if no pair is checked."""
        return min((each for each in (self.path, self.motion) if each is not None), key=lambda e: e.min, default=None)

    @property
    def is_close(self) -> bool:
        """Whether a distance is below ``CLOSE``."""
        return self.least is not None and self.least.min < CLOSE

    @property
    def least_text(self) -> str:
        """The smallest distance as a row of the summary."""
        return NOTHING_NEAR if self.least is None else nearest_text(self.least)


@dataclass(frozen=True, kw_only=True, eq=False)
class LengthRecord(Record):
    """Lengths of the path."""

    joint: float
    """rad"""
    workspace: float
    """length of the tool's path, m"""


@dataclass(frozen=True, kw_only=True, eq=False)
class ConstraintRecord(Record):
    """Slack of a path constraint along path and motion, negative if it is violated."""

    condition: str
    """as --constraint takes it"""
    unit: str
    """unit of the slack"""
    path: float
    """smallest slack along the path, sampled densely"""
    path_proven: bool
    motion: float | None
    """smallest slack in motion; null without a motion"""
    motion_proven: bool | None

    @classmethod
    def from_path(cls, constraints: PathConstraints, path: Floats, trajectory: Trajectory | None) -> list[Self]:
        """Return a record of each constraint, for a path (k, dof) and its motion."""
        if not constraints or not len(path):
            return []
        on_path = constraints.along(dense_path(path), np.stack([path[:-1], np.diff(path, axis=0)], axis=1))
        in_motion = [None] * len(on_path)
        if trajectory is not None:
            in_motion = constraints.along(trajectory.sample(_SAMPLE_PERIOD).positions, trajectory.coefficients)
        return [
            cls(
                condition=kept.condition.text,
                unit=kept.condition.unit,
                path=kept.slack,
                path_proven=kept.proven,
                motion=None if moving is None else moving.slack,
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
class InTimeRecord(Record):
    """Timing and proof of a motion among moving obstacles."""

    moving: list[str]
    """obstacles along a known motion"""
    waypoints: dict[str, list[float]] | None
    """``arrivals`` and ``departures`` at the path's waypoints, s from the scene's time 0; null if no obstacle moves"""
    horizon: dict[str, Any] | None
    """``free_until``, s, null for always, and ``speed_limits``, m/s by obstacle; null if no obstacle has one"""

    @classmethod
    def from_trajectory(cls, scene: Scene, trajectory: Trajectory | None, route: TimedRoute | None) -> Self | None:
        """Return the record of a motion; None without one, or if no obstacle can move."""
        if trajectory is None or not (scene.moving or scene.limited):
            return None
        times, moving = None, [item.name for item in scene.moving]
        if route is not None:
            times = {"arrivals": route.arrivals.tolist(), "departures": route.departures.tolist()}
        return cls(moving=moving, waypoints=times, horizon=trajectory.proof.get("horizon"))

    def rows(self, proven: bool) -> Rows:
        """Return rows for obstacles of known motion, and for those of which only a speed limit is known."""
        rows = []
        if self.waypoints:
            waits = sum(self.waypoints["departures"]) - sum(self.waypoints["arrivals"])
            stands = f"it stands {waits:.3f} s on the way" if waits > 0 else "it need not wait"
            clear = "proven clear" if proven else "NOT proven clear"
            rows.append(("known motions", f"{clear} of {choices(self.moving)}; {stands}"))
        if self.horizon:
            limits = choices(f"{name} below {limit:g} m/s" for name, limit in self.horizon["speed_limits"].items())
            until = self.horizon["free_until"]
            when = "at any time" if until is None else f"before {until:.3f} s"
            rows.append(("horizon", f"no contact {when}, with any motion of {limits}"))
        return rows


@dataclass(frozen=True, kw_only=True, eq=False)
class CellRecord(Record):
    """Times of the robots of a cell, whose motions run on one clock."""

    seconds: dict[str, float]
    """until each robot rests, s"""
    makespan: float
    """until all robots rest, s"""
    flowtime: float
    """sum of the times of all robots, s"""

    @classmethod
    def from_trajectories(cls, motions: Mapping[str, Trajectory]) -> Self | None:
        """Return the times of the motions by robot; None without any."""
        seconds = {name: busy_seconds(motion) for name, motion in motions.items()}
        if not seconds:
            return None
        return cls(seconds=seconds, makespan=max(seconds.values()), flowtime=sum(seconds.values()))

    @property
    def rows(self) -> Rows:
        """The row of the table."""
        each = ", ".join(f"{name} {seconds:.3f} s" for name, seconds in self.seconds.items())
        return [("robots", f"{each}; all rest after {self.makespan:.3f} s, sum of times {self.flowtime:.3f} s")]


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanRecord(RunRecord):
    """The content of plan.json of ``planner plan``; units rad, m and s."""

    reason: Annotated[NoPath, Field(discriminator="kind")] | None
    """why no path was found"""
    path: list[list[float]]
    """joint waypoints, rad (m where a joint slides), start first"""
    path_nodes: Nodes
    """their indices in the roadmap"""
    goal: str | None
    """text of the reached goal"""
    cost: PathCost | None
    quality: QualityRecord | None
    manipulability: ManipulabilityRecord | None
    conditioning: Conditioning | None
    """where w is smallest, and remedies if it is too small"""
    path_length: LengthRecord | None
    clearance: ClearanceRecord | None
    trajectory: MotionRecord | None
    constraints: list[ConstraintRecord]
    """path constraints"""
    in_time: InTimeRecord | None
    """null if no obstacle can move, or without a motion"""
    roadmap: RoadmapRecord
    gabf: FieldRecord | None
    tool_path: ToolPathRecord | None = None
    """of ``planner follow`` only"""
    legs: list[LegRecord] | None = None
    """tool lines of --retreat from the start and --approach to the goal"""
    cell: CellRecord | None = None
    """null for one robot, or without a motion"""

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
        rows += self.cell.rows if self.cell is not None else []
        rows += [("constraint", each.text) for each in self.constraints]
        if self.in_time is not None and motion is not None:
            rows += self.in_time.rows(motion.proven)
        return rows + (self.gabf.rows if self.gabf else [])

    @property
    def summary(self) -> Rows:
        if self.cost is None:
            return [("roadmap", self.roadmap.counts)]
        assert self.manipulability is not None
        assert self.clearance is not None
        assert self.path_length is not None
        length, motion = self.path_length, self.trajectory
        goal = f" to {self.goal}" if self.goal else ""
        path = f"{len(self.path)} waypoints{goal}, {length.joint:.3f} rad; the tool moves {length.workspace:.3f} m"
        rows = [("path", f"{path}; cost {self.cost.total:.4f} at beta {self.cost.beta:g}")]
        if motion is not None:
            rows.append(("motion", f"{motion.duration:.3f} s, {motion.proof_text}"))
        rows += self.cell.rows if self.cell is not None else []
        rows += [("clearance", self.clearance.least_text), ("manipulability", self.manipulability.text)]
        what = "path" if motion is None else "path and motion"
        tool = [] if self.tool_path is None else [text for _, text in self.tool_path.rows(what)]
        tool += [f"{leg.leg} {leg.text(what)}" for leg in self.legs or ()]
        moving = self.in_time.rows(motion.proven) if self.in_time is not None and motion is not None else []
        warnings = [TOO_CLOSE_TEXT] if self.clearance.is_close else []
        if self.conditioning is not None and self.conditioning.advice:
            warnings.append(self.conditioning.advice)
        groups = [("tool path", tool), ("constraints", [each.text for each in self.constraints])]
        groups += [("moving obstacles", [text for _, text in moving]), ("warning", warnings)]
        rows += [(name, "\n".join(texts)) for name, texts in groups if texts]
        return [*rows, ("roadmap", self.roadmap.counts)]

    def _path_rows(self, cost: PathCost) -> Rows:
        assert self.quality is not None
        assert self.manipulability is not None
        assert self.clearance is not None
        assert self.path_length is not None
        rows = [("cost", cost_text(cost)), *self.quality.rows(cost, self.in_time is not None)]
        rows.append(("manipulability w", self.manipulability.text))
        if self.conditioning is not None and self.conditioning.advice:
            rows.append((CONDITIONING, self.conditioning.advice))
        rows += self.clearance.rows(self.config["extra_clearance"])
        length = f"{self.path_length.joint:.3f} rad, {self.path_length.workspace:.3f} m"
        return [*rows, ("goal reached", self.goal or ""), ("path", f"{len(self.path)} waypoints, {length}")]
