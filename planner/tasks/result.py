"""A planned task, its inputs and its files."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from planner import gabf
from planner.base.arrays import Floats
from planner.base.errors import FileError, Reason, choices, format_quantity
from planner.base.files import StrPath
from planner.base.yamlfile import Whole, read_text
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import tool_pose
from planner.planning.base_result import (
    ROADMAP_NAME,
    FieldRecord,
    MotionRecord,
    Result,
    RunRecord,
    cost_text,
    read_record,
)
from planner.planning.result import Plan
from planner.problem.conditions import parse_constraints
from planner.problem.options import RobotLike
from planner.problem.outcome import Outcome, Record, Rows
from planner.problem.request import TaskRequest
from planner.query.query import make_checker_for
from planner.query.robots import placement_in_hand
from planner.roadmap.roadmap import Roadmap, RoadmapRecord
from planner.roadmap.storage import load_roadmap, read_world_request, save_roadmap
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Obstacle
from planner.search.network import PathCost
from planner.tasks.candidates import Candidates
from planner.tasks.network import TaskNetwork
from planner.tasks.segments import Event, Segment
from planner.tasks.task import Task
from planner.tradeoff.result import Tradeoff
from planner.trajectory.file import TRAJECTORY_NAME, parse_json
from planner.trajectory.trajectory import Trajectory
from planner.view.motion import ShownMotion, ShownPath, path_rows
from planner.view.page import Page, command_line

_SAMPLE_PERIOD = 0.02  # s between two poses of an object on the page
_NAMED = 3  # contacts in the sentence


@dataclass(frozen=True, kw_only=True, eq=False)
class StepFails(Reason):
    """The first infeasible step: it has no grasp, no placement, or no path."""

    kind: Literal["step_fails"] = "step_fails"
    step: Whole
    """from 1"""
    doing: str
    """the step in words"""
    what: Literal["no_grasp", "no_placement", "no_path"]
    tried: int
    """number of grasps, or of pairs of a grasp and a placement"""
    out_of_reach: int
    """number of these out of reach"""
    violations: int
    """number of these that violate a constraint"""
    contacts: dict[str, int]
    """counts of first contacts by pair, of those with all configurations in contact"""
    conditions: tuple[str, ...] = ()
    """path constraints"""
    beyond: float | None = None
    """m from the nearest target to the tool's reach, a lower bound on the shift that could work; null if not proven"""

    @property
    def names(self) -> frozenset[str]:
        return frozenset(part.strip("'") for pair in self.contacts for part in pair.split("' and '"))

    @property
    def sentence(self) -> str:
        counts = f"{self.out_of_reach} of {self.tried} out of reach"
        counts += f" (the nearest by {format_quantity(self.beyond, 'm')} or more)" if self.beyond else ""
        for pair, count in list(self.contacts.items())[:_NAMED]:
            counts += f", {count} in contact ({pair})"
        if self.violations:
            counts += f", {self.violations} against constraints ({choices(self.conditions)})"
        less = ", or fewer constraints" if self.violations else ""
        why = {
            "no_grasp": f"no grasp is feasible, {counts}: move the object or the robot, or give other grasps{less}.",
            "no_placement": f"no placement is feasible, {counts}: give another region, or more samples{less}.",
            "no_path": f"no path was found within the budget{f' ({counts})' if self.tried else ''}: raise --nodes, or "
            "try another --seed.",
        }
        return f"Step {self.step} ({self.doing}) cannot be done: {why[self.what]}"


@dataclass(frozen=True, kw_only=True, eq=False)
class ModesRecord(Record):
    """Size of the network over all modes, and number of proofs."""

    modes: int
    nodes: int
    arcs: int
    pieces_proven: int
    rounds: int
    """number of solutions of the field"""
    arcs_refused: int


@dataclass(frozen=True, kw_only=True, eq=False)
class TaskPlanRecord(RunRecord):
    """The content of plan.json of ``planner task``; units rad, m and s."""

    task: str
    reason: StepFails | None
    """the infeasible step"""
    path: list[list[float]]
    """joint waypoints of all segments, start first"""
    cost: PathCost | None
    segments: list[Segment]
    events: list[Event]
    trajectory: MotionRecord | None
    """of all segments; null without times"""
    roadmap: RoadmapRecord | None
    """null if a step has no candidate"""
    modes: ModesRecord | None
    gabf: FieldRecord | None

    @property
    def rows(self) -> Rows:
        rows: Rows = [] if self.roadmap is None else [("roadmap", self.roadmap.text)]
        if self.modes is not None:
            m = self.modes
            rows.append(("modes", f"{m.modes} over {m.nodes} nodes, {m.arcs_refused} of {m.arcs} arcs refused"))
        return rows + self._path_rows + (self.gabf.rows if self.gabf else [])

    @property
    def summary(self) -> Rows:
        return self._path_rows + ([] if self.roadmap is None else [("roadmap", self.roadmap.counts)])

    @property
    def _path_rows(self) -> Rows:
        """The cost, the segments and the motion."""
        rows: Rows = []
        if self.cost is not None:
            rows.append(("cost", cost_text(self.cost)))
        for k, segment in enumerate(self.segments, start=1):
            held, timed = f", holding {segment.carried}" if segment.carried else "", segment.trajectory
            motion = f", {timed.duration:.2f} s{'' if timed.proven else ', NOT proven'}" if timed else ""
            what = f"step {segment.step}, {segment.doing}: {segment.part}{held}{motion}"
            rows.append((f"segment {k}", what))
        if self.trajectory is not None:
            proven = "all proven" if self.trajectory.proven else "not all proven"
            rows.append(("motion", f"{self.trajectory.duration:.2f} s, {proven}"))
        return rows


@dataclass(frozen=True, eq=False, repr=False)
class TaskPlan(Result[TaskPlanRecord]):
    """The plan of a task; after a failure ``segments`` and ``events`` are empty, and ``reason`` is set.

    ``cost`` is that of the path over the roadmaps, by eq. (finew); ``cost_to_go`` the field over all nodes of
    ``network``. ``trajectory`` is one motion of all segments, at rest while a gripper moves; None without times.
    ``candidates`` are those of all steps; None for a loaded plan.
    """

    FILES: ClassVar = Plan.FILES

    request: TaskRequest
    task: Task
    robot: Robot
    scene: Scene
    candidates: Candidates | None
    roadmap: Roadmap | None = None
    network: TaskNetwork | None = None
    cost_to_go: gabf.CostToGo | None = None
    cost: PathCost | None = None
    segments: tuple[Segment, ...] = ()
    events: tuple[Event, ...] = ()
    trajectory: Trajectory | None = None
    reason: StepFails | None = field(default=None, kw_only=True)
    modes: ModesRecord | None = None
    saved: TaskPlanRecord | None = None  # of a loaded plan

    @classmethod
    def load(cls, folder: StrPath, *, robot: RobotLike | None = None, scene: RobotLike | None = None) -> TaskPlan:
        """Load the plan of a task that was saved in ``folder``, in its world.

            planner.TaskPlan.load("out").trajectory

        As :meth:`planner.Plan.load`. Files do not hold steps, candidates, network and field: ``task.steps`` is empty,
        the others are None.
        """
        folder = Path(folder)
        record = read_record(TaskPlanRecord, folder / cls.JSON)
        task = Task(robot or record.config["robot"], scene or record.config["scene"], (), name=record.task)
        world = read_world_request(record.config | {"robot": task.robot, "scene": task.scene}, f"in {folder}")
        checker, how = (
            make_checker_for(world),
            (TaskRequest.from_config(record.config), Outcome[record.outcome.upper()]),
        )
        plan = TaskPlan(*how, task, checker.robot, checker.world.scene, None, saved=record, reason=record.reason)
        return replace(
            plan,
            roadmap=load_roadmap(folder / ROADMAP_NAME) if record.roadmap else None,
            cost=record.cost,
            segments=tuple(record.segments),
            events=tuple(record.events),
            trajectory=Trajectory.load(folder) if record.trajectory else None,
            modes=record.modes,
        )

    def __repr__(self) -> str:
        size = f"{len(self.segments)} segments" if self.segments else "no plan"
        return f"<TaskPlan: {self.task.name} by {self.robot.name}, {self.outcome.key}, {size}>"

    @cached_property
    def path(self) -> Floats:
        """Waypoints (k, dof) of all segments, each rest once."""
        if not self.segments:
            return np.zeros((0, self.robot.dof))
        return np.vstack([self.segments[0].path[:1], *(segment.path[1:] for segment in self.segments)])

    @cached_property
    def checker(self) -> CollisionChecker:
        """The checker of the scene before the task."""
        what, constraint = self.request.what, parse_constraints(self.scene.constraints)
        return make_checker(self.robot, self.scene, what.collision, what.margin, constraint)

    @cached_property
    def record(self) -> TaskPlanRecord:
        """The content of ``plan.json``; units in rad, m and s."""
        if self.saved is not None:
            return self.saved
        record = TaskPlanRecord.from_run(
            self,
            self.robot,
            self.scene,
            task=self.task.name,
            reason=self.reason,
            path=self.path.tolist(),
            cost=self.cost,
            segments=list(self.segments),
            events=list(self.events),
            trajectory=MotionRecord.from_trajectory(self.trajectory, self.robot),
            roadmap=None if self.roadmap is None else self.roadmap.record(),
            modes=self.modes,
            gabf=FieldRecord.from_field(self.request.quality, self.cost_to_go),
        )
        world = {"robot": self.task.robot, "scene": self.task.scene}  # as the task names them
        names = {
            key: str(value) if isinstance(value, str | os.PathLike) else value.name for key, value in world.items()
        }
        return replace(record, config=record.config | names)

    def page(self) -> str:
        """Return the page as HTML: the motion of all segments, with picked objects moving with the hand."""
        scene, start, paths = self.scene, self.robot.home, []
        if self.roadmap is not None:
            start = self.roadmap.nodes[self.roadmap.starts[0]]
        elif self.candidates is not None:
            start = self.candidates.start[0]
        if self.cost is not None:
            motion = self.trajectory
            if motion is not None:
                scene = _scene_in_motion(self, motion)
            rows = path_rows(self.robot, self.path, self.cost.manipulability, self.cost.distance)
            start, shown = self.path[0], None if motion is None else ShownMotion(motion, None)
            paths = [ShownPath(self.path, rows, motion=shown)]
        touching = frozenset() if self.reason is None else self.reason.names
        known = {"notes": self.end_notes, "command": command_line("task FILE", self.request), "planned_in": self.scene}
        page = Page(self.robot, scene, start, self.message, self.record.rows, touching=touching, **known)
        if self.roadmap is not None:
            page.add_roadmap(replace(self.roadmap, goals=self.roadmap.goals[:0]))
        if paths:
            page.add_paths(paths, beta=self.request.quality.beta)
        return page.html()

    def _write(self, folder: Path) -> None:
        """Write ``roadmap.npz`` and ``trajectory.json``, if any, into an empty ``folder``."""
        if self.roadmap is not None:
            save_roadmap(self.roadmap, folder / ROADMAP_NAME)
        if self.trajectory is not None:
            self.trajectory.save(folder / TRAJECTORY_NAME, self.robot.name, self.scene.name)


def _scene_in_motion(plan: TaskPlan, motion: Trajectory) -> Scene:
    """Return the scene with picked objects as obstacles that move with the hand."""
    times = np.linspace(0.0, motion.duration, max(2, int(motion.duration / _SAMPLE_PERIOD)))
    events = [(event.t, event) for event in plan.events if event.kind != "gripper" and event.t is not None]
    at = np.unique(np.concatenate([times, [t for t, _ in events]]))
    at = at[np.append(True, np.diff(at) > 1e-5)]
    names, held = {event.object for _, event in events}, None
    objects: dict[str, Obstacle | Carried] = {item.name: item for item in plan.scene.obstacles if item.name in names}
    poses = {name: [item.placement] for name, item in objects.items()}

    def hand(t: float) -> Floats:
        return tool_pose(plan.robot, motion.at(t)[0]).homogeneous

    for item in plan.scene.carried:  # held at the start
        if item.name in names - set(objects):
            objects[item.name], first = item, placement_in_hand(item, plan.robot, motion.at(0.0)[0])
            poses[item.name], held = [first], (item.name, np.linalg.inv(hand(0.0)) @ first)
    for now in at.tolist():
        while events and events[0][0] <= now:
            t, event = events.pop(0)
            if event.kind == "attach":
                held = event.object, np.linalg.inv(hand(t)) @ poses[event.object][-1]
            elif held is not None:
                poses[held[0]][-1], held = hand(t) @ held[1], None
        if held is not None:
            poses[held[0]][-1] = hand(now) @ held[1]
        for listed in poses.values():
            listed.append(listed[-1])
    moving = tuple(
        MovingObstacle(name, item.shape, KnownMotion(at, np.array(poses[name][:-1]))) for name, item in objects.items()
    )
    carried = tuple(item for item in plan.scene.carried if item.name not in objects)
    return replace(scene_without(plan.scene, set(objects)), moving=moving, carried=carried)


def scene_without(scene: Scene, names: set[str]) -> Scene:
    """Return the scene without the obstacles ``names``."""
    return replace(scene, obstacles=tuple(item for item in scene.obstacles if item.name not in names))


def load(folder: StrPath) -> Plan | Tradeoff | TaskPlan:
    """Load the plan, the sweep or the task plan in a ``folder``.

        planner.load("out").record.rows

    As :meth:`planner.Plan.load`; :class:`FileError` for a folder with none of these, or with two.
    """
    files = [name for name in (Plan.JSON, Tradeoff.JSON) if os.path.isfile(Path(folder) / name)]
    if len(files) != 1:
        raise FileError(f"{folder} must be a folder with {Plan.JSON} or {Tradeoff.JSON}, got {choices(files)}.")
    if files == [Tradeoff.JSON]:
        return Tradeoff.load(folder)
    data = parse_json(read_text(Path(folder) / Plan.JSON, "plan"), f"plan {folder}")
    return (TaskPlan if isinstance(data, dict) and "segments" in data else Plan).load(folder)
