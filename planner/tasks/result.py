"""A planned task with everything it was made from, and its files."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from planner import gabf
from planner.base.arrays import Floats
from planner.base.files import StrPath, staged
from planner.base.progress import Stopwatch, rounded
from planner.base.resolutions import RECHECK
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.planning.result import JSON_NAME, NAMES, PAGE_NAME, field_record, motion_record, save_parts
from planner.planning.run_record import run_record
from planner.planning.summary import cost_text, field_rows
from planner.problem.outcome import Outcome
from planner.problem.request import TaskRequest
from planner.roadmap.record_text import roadmap_text
from planner.roadmap.roadmap import Roadmap
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.search.network import PathCost
from planner.tasks.file import Task
from planner.tasks.judge import SegmentReport, Stage, TaskRecord, judged
from planner.tasks.network import TaskNetwork
from planner.tasks.options import Options
from planner.tasks.record import Event, ModesRecord, SegmentRecord, StepFails, TaskPlanRecord
from planner.tasks.segments import Segment, begins_of, joined
from planner.trajectory.trajectory import Trajectory
from planner.view.page import Content, page, save_page
from planner.view.shown_path import Rows, ShownMotion, ShownPath, path_rows

_SHOWN_APART = 0.02  # s between two poses of an object that a page moves


@dataclass(frozen=True, eq=False)
class TaskPlan:
    """A task's plan; ``segments`` and ``events`` are empty where there is none, and ``reason`` says why.

    ``cost`` is that of the path over the roadmaps, as eq. (finew) sums it; ``cost_to_go`` the field over all modes,
    which knows it of every node of ``network``. ``rounds`` is how often the field was solved, ``refused`` how many arcs
    of the network were refused meanwhile.
    """

    request: TaskRequest
    task: Task
    outcome: Outcome
    robot: Robot
    scene: Scene
    options: Options
    roadmap: Roadmap | None = None
    network: TaskNetwork | None = None
    cost_to_go: gabf.CostToGo | None = None
    cost: PathCost | None = None
    segments: tuple[Segment, ...] = ()
    events: tuple[Event, ...] = ()
    reason: StepFails | None = None
    rounds: int = 0
    refused: int = 0
    end_notes: tuple[str, ...] = ()  # on the start
    timings: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        size = f"{len(self.segments)} segments" if self.segments else "no plan"
        return f"<TaskPlan: {self.task.name} by {self.robot.name}, {self.outcome.key}, {size}>"

    @property
    def solved(self) -> bool:
        """Whether there is a path."""
        return self.outcome is Outcome.SOLVED

    @property
    def message(self) -> str:
        """How the task ended, in one sentence."""
        return self.outcome.value if self.reason is None else self.reason.sentence

    @cached_property
    def path(self) -> Floats:
        """All waypoints (k, dof) of all segments, each rest once."""
        if not self.segments:
            return np.zeros((0, self.robot.dof))
        return np.vstack([self.segments[0].path[:1], *(segment.path[1:] for segment in self.segments)])

    @cached_property
    def trajectory(self) -> Trajectory | None:
        """One motion of all segments, at rest while a gripper moves; None without times."""
        return joined(self.segments, self.events)

    def check(self, step: float = RECHECK) -> list[SegmentReport]:
        """Each segment as ``planner check`` judges a task, from its record: see :func:`planner.tasks.judge.judged`."""
        names, path, events = list(self.robot.joints), self.path.tolist(), list(self.events)
        record = TaskRecord(outcome=self.outcome.key, joints=names, path=path, segments=self._segments(), events=events)
        return [report for _, report in judged(record, self.judge, self.trajectory, step)]

    @cached_property
    def judge(self) -> CollisionChecker:
        """A checker of the scene before the task."""
        world = self.options.modes.checker.world
        return make_checker(world.robot, self.scene, self.request.what.collision, world.margin, world.conditions)

    def to_dict(self) -> dict[str, Any]:
        """The keys of ``plan.json``; units in rad, m and s."""
        begun: dict[str, Any] = run_record(self.request, self.outcome, self.robot, self.scene)
        begun |= {"message": self.message, "notes": [*begun["notes"], *self.end_notes]}
        net, x = self.network, self.cost_to_go
        record = TaskPlanRecord(
            **begun,
            task=self.task.name,
            reason=self.reason,
            path=self.path.tolist(),
            cost=self.cost,
            segments=self._segments(),
            events=list(self.events),
            trajectory=motion_record(self.trajectory, self.robot),
            roadmap=None if self.roadmap is None else self.roadmap.record(),
            modes=None
            if net is None
            else ModesRecord(
                modes=len(net.modes),
                nodes=net.nodes,
                arcs=len(net.tails),
                pieces_proven=self.options.modes.pieces_proven,
                rounds=self.rounds,
                arcs_refused=self.refused,
            ),
            gabf=None
            if x is None
            else field_record(
                self.request.quality, x, gabf.certify(x.network, x.law, x), gabf.max_error(x, gabf.oracle(x.network))
            ),
            timings_s=rounded(self.timings),
        )
        return record.to_dict()

    def _segments(self) -> list[SegmentRecord]:
        begins = begins_of(self.segments, self.events)
        return [segment.record(begin / 1e9) for segment, begin in zip(self.segments, begins, strict=True)]

    def page(self) -> str:
        """The page as HTML text: the whole motion, the objects that are picked going along with the hand."""
        scene, start, paths = self.scene, self.options.start[0], []
        if self.cost is not None:
            motion = self.trajectory
            if motion is not None:
                scene = _scene_in_motion(self, motion)
            rows = path_rows(self.robot, self.path, self.cost.manipulability, self.cost.distance)
            start, shown = self.path[0], None if motion is None else ShownMotion(motion, None)
            paths = [ShownPath(self.path, rows, motion=shown)]
        content = Content(
            self.robot,
            scene,
            self.message,
            start,
            details=task_rows(self.to_dict()),
            roadmap=None if self.roadmap is None else replace(self.roadmap, goals=self.roadmap.goals[:0]),
            paths=paths,
            beta=self.request.quality.beta,
            touching=frozenset() if self.reason is None else self.reason.names,
        )
        return page(content)

    def save(self, folder: StrPath) -> None:
        """Write ``plan.json``, ``plan.html``, and where there are such ``roadmap.npz`` and ``trajectory.json``."""
        save_task(self, Path(folder))


def save_task(plan: TaskPlan, folder: Path, clock: Stopwatch | None = None) -> dict[str, Any]:
    """Write the files; the stages of ``clock`` go with the plan's own. Returns the record that was written."""
    clock = clock or Stopwatch(plan.timings)
    clock.seconds.update(plan.timings)
    with staged(folder, NAMES) as inner:
        with clock("files"):
            save_parts(inner, plan.roadmap, plan.trajectory, plan.robot.name, plan.scene.name)
        with clock("record"):
            record = plan.to_dict()
        return save_page(plan.page, inner / PAGE_NAME, record, inner / JSON_NAME, clock)


def task_rows(record: dict[str, Any]) -> Rows:
    """What the terminal's table and the page say about a planned task."""
    rows: Rows = []
    if record["roadmap"]:
        rows.append(("roadmap", roadmap_text(record["roadmap"])))
    if record["modes"]:
        m = record["modes"]
        rows.append(("modes", f"{m['modes']} over {m['nodes']} nodes, {m['arcs_refused']} of {m['arcs']} arcs refused"))
    if record["cost"]:
        rows.append(("cost", cost_text(record["cost"])))
    for k, segment in enumerate(record["segments"], start=1):
        held = f", holding {segment['carried']}" if segment["carried"] else ""
        timed = segment["trajectory"]
        motion = f", {timed['duration']:.2f} s{'' if timed['proven'] else ', NOT proven'}" if timed else ""
        what = f"step {segment['step']}, {segment['doing']}: {segment['part']}{held}{motion}"
        rows.append((f"segment {k}", what))
    if record["trajectory"]:
        whole = record["trajectory"]
        rows.append(("motion", f"{whole['duration']:.2f} s, {'all proven' if whole['proven'] else 'not all proven'}"))
    return rows + (field_rows(record["gabf"]) if record["gabf"] else [])


def _scene_in_motion(plan: TaskPlan, motion: Trajectory) -> Scene:
    """The scene with what is picked as obstacles that move as the hand moves them."""
    names, stage = plan.options.modes.objects, Stage(plan.judge, plan.events)
    times = np.linspace(0.0, motion.duration, max(2, int(motion.duration / _SHOWN_APART)))
    left = [(event.t, event) for event in plan.events if event.t is not None]
    at = np.unique(np.concatenate([times, [t for t, _ in left]]))
    at = at[np.append(True, np.diff(at) > 1e-5)]
    poses: dict[str, list[Floats]] = {name: [] for name in names}
    for now in at.tolist():
        while left and left[0][0] <= now:
            t, event = left.pop(0)
            stage.after(event, motion.at(t)[0])
        for name, found in poses.items():
            found.append(stage.pose(name, motion.at(now)[0]))
    moving = tuple(
        MovingObstacle(name, item.shape, KnownMotion(at, np.array(poses[name]))) for name, item in names.items()
    )
    carried = tuple(item for item in plan.scene.carried if item.name not in names)
    return replace(scene_without(plan.scene, set(names)), moving=moving, carried=carried)


def scene_without(scene: Scene, names: set[str]) -> Scene:
    """The scene without some obstacles."""
    return replace(scene, obstacles=tuple(item for item in scene.obstacles if item.name not in names))
