"""A plan, its inputs and its files: plan.json, plan.html, roadmap.npz and trajectory.json."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, frozen
from planner.base.files import StrPath
from planner.certificate.certificate import PROOF_NAME, Certificate, make_certificate
from planner.collision.checker import CollisionChecker
from planner.planning.base_result import (
    JSON_NAME,
    PAGE_NAME,
    ROADMAP_NAME,
    FieldRecord,
    MotionRecord,
    Result,
    read_record,
)
from planner.planning.quality import ManipulabilityRecord, QualityRecord, measure_conditioning
from planner.planning.record import (
    CONDITIONING,
    CellRecord,
    ClearanceRecord,
    ConstraintRecord,
    InTimeRecord,
    LengthRecord,
    PlanRecord,
)
from planner.problem.options import RobotLike
from planner.problem.outcome import NoPath, Outcome
from planner.problem.request import FollowRequest, PlanRequest
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap, reopen_plan, save_roadmap
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.search.manipulability_floor import LayeredNetwork
from planner.search.network import PathCost
from planner.tool_paths.tool_motion import FollowedPath, LegRecord, leg_line
from planner.trajectory.file import TRAJECTORY_NAME
from planner.trajectory.measure import (
    TOO_CLOSE,
    joint_path_length,
    nearest_in_motion,
    nearest_on_path,
    tool_path_length,
    w_along_path,
)
from planner.trajectory.parts import busy_seconds, split_trajectory
from planner.trajectory.safe_intervals import TimedRoute
from planner.trajectory.trajectory import Trajectory
from planner.view.motion import ShownPath, path_rows, sample_motion
from planner.view.page import Page, command_line

PART_NAME = "trajectory-{}.json"  # of one robot of a cell
Curve: TypeAlias = tuple[tuple[int, float], ...]
"""(rounds, best cost) of the refinement at the plan's own beta."""


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Result[PlanRecord]):
    """A plan with its inputs; ``path`` (k, dof) and ``path_nodes`` (k,) are empty if no path exists.

    Continuous joints are unwound along the path, so it has no jumps. ``layered`` is the network of the dynamics: the
    roadmap, or with a manipulability floor the layers of :mod:`planner.search.manipulability_floor`. ``cost_to_go`` is
    over the nodes of ``layered``. ``goal`` is the text of the reached goal, ``alternatives`` are the paths of other
    betas, see :mod:`planner.tradeoff.sweep`.
    """

    FILES: ClassVar = (ROADMAP_NAME, TRAJECTORY_NAME, PROOF_NAME, PAGE_NAME, JSON_NAME)

    request: PlanRequest | FollowRequest
    checker: CollisionChecker
    roadmap: Roadmap
    reason: NoPath | None = field(default=None, kw_only=True)
    layered: LayeredNetwork | None = None
    cost_to_go: gabf.CostToGo | None = None
    path: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    path_nodes: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    goal: str | None = None
    cost: PathCost | None = None
    curve: Curve = ()
    clearance_kept: float = 0.0  # m beyond the margin, of all edges of the network
    edges_removed: int = 0
    trajectory: Trajectory | None = None
    route: TimedRoute | None = None  # arrival and departure at each waypoint, among moving obstacles
    alternatives: tuple[ShownPath, ...] = ()
    tool_path: FollowedPath | None = None
    legs: tuple[LegRecord, ...] = ()  # straight tool lines at the ends of the path
    saved: PlanRecord | None = None  # of a loaded plan

    @classmethod
    def load(cls, folder: StrPath, *, robot: RobotLike | None = None, scene: RobotLike | None = None) -> Plan:
        """Load the plan that was saved in ``folder``: path, motion, roadmap, costs and record, in its world.

            planner.plan("panda", "shelf").save("out")
            plan = planner.Plan.load("out")
            plan.robot, plan.path, plan.trajectory, planner.check(plan).sentence

        ``plan.json`` names robot and scene; give them if the plan was made from objects. A file does not hold
        ``cost_to_go``, ``layered``, ``route``, ``alternatives`` and the line of a tool path: they are None or empty,
        and ``planner.plan(request=plan.request, roadmap="out/roadmap.npz")`` solves again. Raises
        :class:`PlannerError` for missing or damaged files, and if robot or scene have changed.
        """
        folder = Path(folder)
        record = read_record(PlanRecord, folder / JSON_NAME)
        named = {key: value for key, value in (("robot", robot), ("scene", scene)) if value is not None}
        checker = reopen_plan(record.config | named, folder / ROADMAP_NAME)
        known: dict[str, Any] = {name: getattr(record, name) for name in ("reason", "goal", "cost")}
        if record.clearance and record.quality:
            known["clearance_kept"] = record.clearance.kept
            known["curve"] = tuple((point.rounds, point.cost) for point in record.quality.curve)
        if record.tool_path:
            known["tool_path"] = FollowedPath(record.tool_path, np.zeros((0, 3)), np.zeros((0, checker.robot.dof)))
        return Plan(
            (PlanRequest if record.tool_path is None else FollowRequest).from_config(record.config),
            Outcome[record.outcome.upper()],
            checker,
            load_roadmap(folder / ROADMAP_NAME),
            path=frozen(np.reshape(record.path, (len(record.path), checker.robot.dof))),
            path_nodes=frozen(record.path_nodes, np.int64),
            edges_removed=record.roadmap.edges_removed,
            trajectory=Trajectory.load(folder) if record.trajectory else None,
            legs=tuple(record.legs or ()),
            saved=record,
            timings={stage: seconds for stage, seconds in record.timings_s.items() if stage != "total"},
            **known,
        )

    def __repr__(self) -> str:
        size = f"{len(self.path)} waypoints" if len(self.path) else "no path"
        return f"<Plan: {self.robot.name} in {self.scene.name}, {self.outcome.key}, {size}>"

    @property
    def robot(self) -> Robot:
        return self.checker.robot

    @property
    def scene(self) -> Scene:
        return self.checker.world.scene

    @cached_property
    def trajectories(self) -> dict[str, Trajectory]:
        """The motion of each robot of a cell by name, on one clock; empty for one robot."""
        return {} if self.trajectory is None else split_trajectory(self.trajectory, self.robot)

    @property
    def makespan(self) -> float:
        """Seconds until all robots rest; 0 without a motion."""
        return 0.0 if self.trajectory is None else busy_seconds(self.trajectory)

    @property
    def flowtime(self) -> float:
        """Sum of the seconds until each robot of a cell rests."""
        return sum(map(busy_seconds, self.trajectories.values()))

    @property
    def network(self) -> gabf.Network | None:
        """The network of ``layered``."""
        return None if self.layered is None else self.layered.network

    @cached_property
    def max_error_vs_oracle(self) -> float | None:
        """Largest error against Dijkstra's x*, relative to max(1, |x*|); None without a field."""
        field = self.cost_to_go
        return None if field is None else gabf.max_error(field, gabf.oracle(field.network))

    @property
    def bounds(self) -> tuple[gabf.Certificate, ...]:
        """Bounds of the paper that apply to the last run of the dynamics."""
        field = self.cost_to_go
        return () if field is None else tuple(gabf.certify(field.network, field.law, field))

    @cached_property
    def clearance(self) -> ClearanceRecord | None:
        """Smallest distances of path and motion to obstacles and to the robot itself; None without a path."""
        if not len(self.path):
            return None
        motion = None if self.trajectory is None else nearest_in_motion(self.trajectory, self.checker)
        return ClearanceRecord(path=nearest_on_path(self.path, self.checker), motion=motion, kept=self.clearance_kept)

    @property
    def w_along_path(self) -> tuple[Floats, Floats]:
        """Joint motion s (n,) rad and Yoshikawa's w (n,) there, every 0.01 rad; empty without a path."""
        return w_along_path(self.robot, self.path) if len(self.path) else (np.zeros(0), np.zeros(0))

    @property
    def node_costs(self) -> Floats | None:
        """Cost-to-go (n,) of the roadmap's nodes, inf for nodes added after the field; None without a field."""
        if self.layered is None or self.cost_to_go is None:
            return None
        x = self.layered.on_roadmap(self.cost_to_go.x)
        return np.concatenate([x, np.full(len(self.roadmap.nodes) - len(x), np.inf)])

    @cached_property
    def record(self) -> PlanRecord:
        """The content of ``plan.json``; units in rad, m and s."""
        if self.saved is not None:
            return self.saved
        robot, roadmap, quality, path, cost = self.robot, self.roadmap, self.request.quality, self.path, self.cost
        of_path: dict[str, Any] = dict.fromkeys(("manipulability", "conditioning", "path_length"))
        if len(path):
            of_path = {
                "manipulability": ManipulabilityRecord.from_path(robot, path, quality.min_manipulability),
                "conditioning": measure_conditioning(robot, roadmap, path, quality),
                "path_length": LengthRecord(joint=joint_path_length(path), workspace=tool_path_length(robot, path)),
            }
        return PlanRecord.from_run(
            self,
            robot,
            self.scene,
            reason=self.reason,
            path=path.tolist(),
            path_nodes=self.path_nodes.tolist(),
            goal=self.goal,
            cost=cost,
            quality=None
            if cost is None
            else QualityRecord.from_path(quality, roadmap, robot, path, cost.total, self.curve),
            **of_path,
            clearance=self.clearance,
            trajectory=MotionRecord.from_trajectory(self.trajectory, robot),
            constraints=ConstraintRecord.from_path(self.checker.world.constraints, path, self.trajectory),
            in_time=InTimeRecord.from_trajectory(self.scene, self.trajectory, self.route),
            roadmap=roadmap.record(self.edges_removed),
            gabf=FieldRecord.from_field(quality, self.cost_to_go),
            tool_path=None if self.tool_path is None else self.tool_path.record,
            legs=list(self.legs) or None,
            cell=CellRecord.from_trajectories(self.trajectories),
        )

    def certify(self) -> Certificate | None:
        """Return a certificate for an independent checker; None without a path."""
        if not self.solved:
            return None
        return make_certificate(self.checker, self.path, self.trajectory, self.request.quality.min_manipulability)

    def _write(self, folder: Path) -> None:
        """Write ``roadmap.npz``, and ``trajectory.json`` if there is a motion, into an empty ``folder``."""
        save_roadmap(self.roadmap, folder / ROADMAP_NAME)
        if self.trajectory is not None:
            self.trajectory.save(folder / TRAJECTORY_NAME, self.robot.name, self.scene.name)
        for name, motion in self.trajectories.items():
            motion.save(folder / PART_NAME.format(name), name, self.scene.name)

    def files(self, folder: Path) -> Sequence[str]:
        """Return the files of the plan; of a cell also a trajectory of each robot."""
        return [*map(PART_NAME.format, self.trajectories), *self.FILES]

    def page(self) -> str:
        """Return the page as self-contained HTML; without a path the roadmap shows how far planning came."""
        record, (paths, current) = self.record, self.page_paths()
        q = paths[current].path[0] if paths else self.roadmap.nodes[self.roadmap.starts[0]]
        wrong = (CONDITIONING, TOO_CLOSE)
        known = {"notes": self.end_notes, "command": self._command}
        page = Page(self.robot, self.scene, q, record.message, record.rows, wrong=wrong, reason=self.reason, **known)
        for leg in self.legs:
            end = self.path[0 if leg.leg == "retreat" else -1]
            page.add_tool_line(leg_line(self.robot, end, leg.length), leg.tube.position)
        if self.tool_path is not None and len(self.tool_path.points):
            page.add_tool_line(self.tool_path.points, self.tool_path.record.tube.position)
            page.add_rungs(self.tool_path.rungs)
        page.add_roadmap(self.roadmap, self.node_costs)
        if paths:
            quality = self.request.quality
            floor, curve = quality.min_manipulability, self.curve
            speed = self.request.values().get("tool_speed")
            page.add_paths(paths, current, beta=quality.beta, floor=floor, curve=curve, tool_speed=speed)
        return page.html()

    @property
    def _command(self) -> str:
        """The command line of this plan, without options of the motion: no record holds them."""
        line = command_line("plan" if isinstance(self.request, PlanRequest) else "follow PATH", self.request)
        return f"{line} --no-timing" if self.solved and self.trajectory is None else line

    def page_paths(self) -> tuple[list[ShownPath], int]:
        """Return the paths of the page and the index of the plan's own; none without a path."""
        if self.cost is None:
            return [], 0
        beta, shown = self.request.quality.beta, list(self.alternatives)
        costs = self.cost.manipulability, self.cost.distance
        rows, field = path_rows(self.robot, self.path, *costs), self.node_costs
        motion, near = None if self.trajectory is None else sample_motion(self.trajectory, self.checker), self.clearance
        nearest = None if near is None else near.motion or near.path
        of_path: dict[str, Any] = {"cost_to_go": field, "motion": motion, "nearest": nearest}
        if self.scene.moving:  # beta does not choose the earliest motion
            return [ShownPath(self.path, rows, **of_path)], 0
        for k, other in enumerate(shown):
            assert other.interval is not None
            assert other.costs is not None
            if np.isclose(other.costs, costs, rtol=1e-9).all() and other.interval[0] <= beta <= other.interval[1]:
                own = {"duration": None if motion is None else motion.trajectory.duration}
                own["clearance"] = None if nearest is None else nearest.min
                choice = None if other.choice is None else other.choice | own
                shown[k] = ShownPath(self.path, rows, other.interval, costs=costs, choice=choice, **of_path)
                return shown, k
        # several paths can be optimal at one beta: at 0, at 1, or where intervals meet
        index = sum(other.interval is not None and other.interval[0] < beta for other in shown)
        shown.insert(index, ShownPath(self.path, rows, (beta, beta), costs=costs, **of_path))
        return shown, index
