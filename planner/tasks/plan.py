"""One task planned: options, a roadmap, the network over all modes, its field and proven path. Read this first."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner import gabf
from planner.base.arrays import Floats
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.collision.checker import contact_of
from planner.problem.outcome import Outcome
from planner.problem.request import TaskRequest, TimingRequest, WorldRequest
from planner.problem.targets import parse_target
from planner.query.query import open_world, states_of
from planner.query.resolve import free_configuration, other_turns, resolve
from planner.roadmap.build import build_roadmap
from planner.roadmap.roadmap import Roadmap
from planner.robot.frames import in_world
from planner.robot.scene import Scene
from planner.search.network import PathCost
from planner.tasks.file import Pick, Task, TaskError
from planner.tasks.gripper import gripper_of
from planner.tasks.modes import Modes
from planner.tasks.network import TaskNetwork, task_network
from planner.tasks.options import NOTHING, Options, require_sensible
from planner.tasks.result import TaskPlan, scene_without
from planner.tasks.search import Found, LazySearch
from planner.tasks.segments import events_of, segments_of, timed
from planner.tasks.why import why_stuck
from planner.tradeoff.envelope import Piece

_ENDS = 12  # of lines, that the roadmap grows towards


def task(
    what: Task | StrPath,
    progress: Progress = QUIET,
    timing: TimingRequest | None = None,
    request: TaskRequest | None = None,
    **options: Any,
) -> TaskPlan:
    """Plan a task, given or by its file: grasps, configurations, paths and placements chosen together.

        found = planner.task("task.yaml", beta=0.2)
        found.segments, found.events
        found.save("out")

    ``options`` are fields of :class:`TaskRequest`, in place of those of ``request``. With ``timing`` each segment
    becomes a motion too. Raises :class:`PlannerError` for what is unusable; where a step cannot be done the plan says
    which one, and why.
    """
    return TaskPlanner.of(what, request, progress, **options).plan(progress=progress, timing=timing)


@dataclass(eq=False)
class TaskPlanner:
    """A task with everything that does not depend on beta or on where the arm is: plan again on what is known.

    planner_ = TaskPlanner.of("task.yaml")
    planner_.plan(beta=0.2), planner_.plan(start=q)
    """

    request: TaskRequest
    task: Task
    options: Options
    scene: Scene
    roadmap: Roadmap | None
    search: LazySearch | None
    clock: Stopwatch  # until the first plan, to which all that counts

    @staticmethod
    def of(
        what: Task | StrPath,
        request: TaskRequest | None = None,
        progress: Progress = QUIET,
        **options: Any,
    ) -> TaskPlanner:
        """Read, find grasps and placements, grow the roadmap, join the modes."""
        clock, request = Stopwatch(), (request or TaskRequest()).with_options(**options)
        what = what if isinstance(what, Task) else Task.load(what)
        with clock("setup"):
            scene = what.scene if isinstance(what.scene, Scene) else Scene.load(str(what.scene))
            scene, modes = _modes(what, scene, request)
            states = states_of(modes.robot, modes.checker.world.scene)
            start = resolve(
                parse_target(what.start), modes.checker, states, "start", tolerance=request.what.ik_tolerance
            )[0]
        with clock("grasps"):
            gripper = gripper_of(modes.robot, what.gripper)
            found = Options(what, modes, gripper, start[None], request.what)
            start = free_configuration(start, modes.checker_of(found.first), "start")
        if found.dead_end is not None:
            return TaskPlanner(request, what, found, scene, None, None, clock)
        with clock("roadmap"):
            ends = _ends(found, modes)
            roadmap = build_roadmap(
                modes.robot, modes.checker, start, ends, request.quality.nodes, request.quality.seed, progress
            )
        with clock("network"):
            law = gabf.named_law(request.quality.law, request.quality.prescribed_time)
            search = LazySearch(modes, task_network(found, roadmap, request.quality.objective), law)
        return TaskPlanner(request, what, found, scene, roadmap, search, clock)

    @property
    def network(self) -> TaskNetwork | None:
        """The network over all modes; None where a step has no options."""
        return None if self.search is None else self.search.network

    def plan(
        self,
        beta: float | None = None,
        start: Floats | None = None,
        progress: Progress = QUIET,
        timing: TimingRequest | None = None,
    ) -> TaskPlan:
        """The plan at another ``beta``, from another ``start`` (dof,): what was proven before is known."""
        clock, self.clock, robot = self.clock, Stopwatch(), self.options.modes.robot
        request = self.request if beta is None else self.request.with_options(beta=beta)
        draft = TaskPlan(request, self.task, Outcome.NO_PATH, robot, self.scene, self.options, timings=clock.seconds)
        if start is None:
            world = self.options.modes.checker
            told = other_turns(parse_target(self.task.start), world, states_of(robot, world.world.scene))
            draft = replace(draft, end_notes=tuple(told))
        if self.search is None or self.roadmap is None:
            return replace(draft, reason=why_stuck(self.options, None))
        search = known = self.search
        with clock("gabf"):
            if start is not None:
                checker = self.options.modes.checker_of(self.options.first)
                q = free_configuration(np.asarray(start, dtype=float), checker, "start")
                search = known.started(known.network.started(self.options, self.roadmap, q, request.quality.objective))
            found = search.path(request.quality.beta, progress)
            known.refused |= search.refused[: len(known.refused)]
        draft = replace(
            draft,
            roadmap=self.roadmap,
            network=search.network,
            cost_to_go=found.field,
            rounds=found.rounds,
            refused=found.refused,
        )
        if progress.stopped:
            return replace(draft, outcome=Outcome.INTERRUPTED)
        if not len(found.arcs):
            return replace(draft, reason=why_stuck(self.options, search))
        with clock("timing"):
            return self._solved(draft, found, timing)

    def intervals(self) -> list[Piece]:
        """Every path through all modes that some beta makes optimal, with its interval; all of them proven.

        Costs are those of ``piece.support``, whose ``nodes`` are of ``network``; none where there is no path.
        """
        return [] if self.search is None else self.search.pieces()

    def _solved(self, draft: TaskPlan, found: Found, timing: TimingRequest | None) -> TaskPlan:
        network, request = draft.network, draft.request
        assert network is not None and self.roadmap is not None  # noqa: PT018
        omega, distance = (float(total) for total in network.costs[found.arcs].sum(axis=0))
        cost = PathCost(request.quality.objective.total(omega, distance), omega, distance, request.quality.beta)
        segments = segments_of(self.options, network, found.arcs)
        if timing is not None:
            segments = timed(segments, self.options, timing, request.quality.objective, self.roadmap.scale)
        events = events_of(segments, self.options)
        return replace(draft, outcome=Outcome.SOLVED, cost=cost, segments=tuple(segments), events=events)


def _modes(what: Task, scene: Scene, request: TaskRequest) -> tuple[Scene, Modes]:
    """The scene in its own frame, and the robot among what is never picked, and what is."""
    held = require_sensible(what, scene)
    if scene.moving or scene.limited:
        raise TaskError(f"in scene '{scene.name}' obstacles move, and a task has no times: give a scene that stands.")
    names = {step.object for step in what.steps if isinstance(step, Pick)}
    fixed = replace(scene_without(scene, names), carried=tuple(item for item in scene.carried if item is not held))
    world = WorldRequest(robot=what.robot, scene=fixed, collision=request.what.collision, margin=request.what.margin)
    checker = open_world(world)
    scene = in_world(scene, checker.robot)
    objects = {item.name: item for item in scene.obstacles if item.name in names}
    modes = Modes(checker, objects)
    if held is not None:
        modes.take(next(item for item in scene.carried if item.name == held.name))
    return scene, modes


def _ends(options: Options, modes: Modes) -> Floats:
    """Ends of lines, evenly of all steps, and the goals of moves, that the roadmap grows towards; free of the fixed."""
    chosen = []
    for step in sorted(options.steps, key=lambda step: NOTHING not in step):  # moves first
        listed = [option for found in step.values() for option in found]
        for k in np.unique(np.linspace(0, len(listed) - 1, min(len(listed), _ENDS)).round().astype(int)):
            chosen.append(listed[k].ends[: 1 + len(listed[k].motions)])
    found = np.vstack(chosen)
    return found[[contact_of(modes.checker, q) is None for q in found]]
