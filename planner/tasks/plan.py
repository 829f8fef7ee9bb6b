"""Plan one task: candidates, roadmap, network of modes, field, proven path. Read this file first."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner import gabf
from planner.base.arrays import Floats
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.collision.checker import contact_at
from planner.kinematics.inverse import beyond_reach
from planner.problem.options import RobotLike
from planner.problem.outcome import Outcome
from planner.problem.request import Objective, TaskRequest, TimingRequest, WorldRequest, build_request
from planner.problem.targets import parse_target
from planner.query.query import make_checker_for, states_of
from planner.query.resolve import free_configuration, other_turns, resolve
from planner.roadmap.build import build_roadmap
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot_in_scene import resolve_frames
from planner.robot.scene import Scene
from planner.search.network import PathCost
from planner.tasks.candidates import NO_OBJECT, Candidates, Rejected, require_sensible
from planner.tasks.modes import Modes
from planner.tasks.network import LazySearch, TaskNetwork, build_task_network
from planner.tasks.result import ModesRecord, StepFails, TaskPlan, scene_without
from planner.tasks.sampling import complete_gripper
from planner.tasks.segments import join, split_into_segments, time_segments
from planner.tasks.task import Move, Pick, Task, TaskError, step_text
from planner.tradeoff.envelope import SupportInterval

_ENDS = 12  # ends of lines per step, goals of the roadmap's growth
_LEAST_BEYOND = 5e-3  # m beyond reach, smallest that a reason names


def task(
    file: Task | StrPath,
    *,
    robot: RobotLike | None = None,
    scene: RobotLike | None = None,
    request: TaskRequest | None = None,
    timing: TimingRequest | None = TimingRequest(),  # noqa: B008 (frozen)
    objective: Objective | None = None,
    progress: Progress = QUIET,
    **options: Any,
) -> TaskPlan:
    """Plan a task or a task file: choose grasps, configurations, paths and placements together.

        plan = planner.task("task.yaml", beta=0.2)
        plan.segments, plan.events
        plan.save("out")

    ``robot`` and ``scene`` replace those of the task; ``options`` are fields of :class:`TaskRequest`. Other arguments
    are as in :func:`planner.plan`, with ``timing`` for each segment. Raises :class:`PlannerError` for unusable input.
    The plan names an infeasible step and its reason.
    """
    what = file if isinstance(file, Task) else Task.load(file)
    named = {key: value for key, value in (("robot", robot), ("scene", scene)) if value is not None}
    request = build_request(request or TaskRequest(), objective, options)
    return TaskPlanner.from_task(replace(what, **named), request, progress).plan(progress=progress, timing=timing)


@dataclass(eq=False)
class TaskPlanner:
    """A task with candidates, roadmap and network, which do not depend on beta or the start.

    task_planner = planner.TaskPlanner.from_task("task.yaml")
    task_planner.plan(beta=0.2), task_planner.plan(start=q), task_planner.intervals()
    """

    request: TaskRequest
    task: Task
    candidates: Candidates
    scene: Scene
    roadmap: Roadmap | None
    search: LazySearch | None
    clock: Stopwatch  # its stages count for the first plan

    @staticmethod
    def from_task(
        what: Task | StrPath, request: TaskRequest | None = None, progress: Progress = QUIET, **options: Any
    ) -> TaskPlanner:
        """Read a task, find the candidates of each step, grow the roadmap, and build the network."""
        clock, request = Stopwatch(), (request or TaskRequest()).with_options(**options)
        what, quality = what if isinstance(what, Task) else Task.load(what), request.quality
        progress("setup", 0, 1)
        with clock("setup"):
            scene, modes = _modes(what, Scene.load(what.scene), request, Progress(progress))
            states = states_of(modes.robot, modes.checker.world.scene)
            target, within = parse_target(what.start), request.what.ik_tolerance
            start = resolve(target, modes.checker, states, "start", tolerance=within)[0]
        progress("setup", 1, 1)
        with clock("grasps"):
            gripper = complete_gripper(modes.robot, what.gripper)
            candidates = Candidates(what, modes, gripper, start[None], request.what)
            start = free_configuration(start, modes.checker_of(candidates.first), "start")
        if candidates.dead_end is not None:
            return TaskPlanner(request, what, candidates, scene, None, None, clock)
        with clock("roadmap"):
            ends, size = _ends(candidates, modes), (quality.nodes, quality.seed)
            roadmap = build_roadmap(modes.robot, modes.checker, start, ends, *size, progress)
        with clock("network"):
            law = gabf.law_from_name(quality.law, quality.prescribed_time)
            search = LazySearch(modes, build_task_network(candidates, roadmap, quality.objective), law)
        return TaskPlanner(request, what, candidates, scene, roadmap, search, clock)

    @property
    def network(self) -> TaskNetwork | None:
        """The network over all modes; None if a step has no candidates."""
        return None if self.search is None else self.search.tasks

    def plan(
        self,
        beta: float | None = None,
        start: Floats | None = None,
        *,
        timing: TimingRequest | None = TimingRequest(),  # noqa: B008 (frozen)
        progress: Progress = QUIET,
    ) -> TaskPlan:
        """Plan at another ``beta`` or from another ``start`` (dof,), with the proofs of earlier plans."""
        clock, self.clock, robot = self.clock, Stopwatch(), self.candidates.modes.robot
        request = self.request if beta is None else self.request.with_options(beta=beta)
        quality = request.quality
        draft = TaskPlan(request, Outcome.NO_PATH, self.task, robot, self.scene, self.candidates, timings=clock.seconds)
        if start is None:
            states = states_of(robot, self.candidates.modes.checker.world.scene)
            notes = other_turns(parse_target(self.task.start), self.candidates.modes.checker, states)
            draft = replace(draft, end_notes=tuple(notes))
        if self.search is None or self.roadmap is None:
            return replace(draft, reason=explain_failure(self.candidates, None))
        search = self.search
        with clock("gabf"):
            if start is not None:
                modes = self.candidates.modes
                q = free_configuration(np.asarray(start, dtype=float), modes.checker_of(self.candidates.first), "start")
                network = search.tasks.with_start(modes, self.roadmap, q, quality.objective)
                search = LazySearch(modes, network, search.law, search.fields)
            result, arcs = search.path(quality.beta, progress)
        network = search.tasks
        draft = replace(
            draft,
            roadmap=self.roadmap,
            network=network,
            cost_to_go=result.field,
            modes=ModesRecord(
                modes=len(network.modes),
                nodes=network.nodes,
                arcs=len(network.tails),
                pieces_proven=self.candidates.modes.pieces_proven,
                rounds=result.rounds,
                arcs_refused=int(search.refused.sum()),
            ),
        )
        if progress.stopped:
            return replace(draft, outcome=Outcome.INTERRUPTED)
        if not len(arcs):
            return replace(draft, reason=explain_failure(self.candidates, search))
        omega, distance = (float(total) for total in network.costs[arcs].sum(axis=0))
        cost = PathCost(quality.objective.total(omega, distance), omega, distance, quality.beta)
        with clock("timing"):
            segments, modes = split_into_segments(self.candidates, network, arcs)
            motions = None
            if timing is not None:
                how = timing, quality.objective, self.roadmap.scale
                motions = time_segments(segments, modes, self.candidates, *how)
            timed, events, trajectory = join(segments, modes, motions, self.candidates)
        motion = {"segments": tuple(timed), "events": tuple(events), "trajectory": trajectory}
        return replace(draft, outcome=Outcome.SOLVED, cost=cost, **motion)

    def intervals(self) -> list[SupportInterval]:
        """Return all proven paths that are optimal for some beta, with their intervals; empty without a path.

        ``support`` of an interval has the costs and the nodes in ``network``.
        """
        return [] if self.search is None else self.search.intervals()


def _modes(what: Task, scene: Scene, request: TaskRequest, progress: Progress) -> tuple[Scene, Modes]:
    """Return the scene in its own frame, and the modes of the robot among fixed obstacles."""
    held = require_sensible(what, scene)
    if scene.moving or scene.limited:
        raise TaskError(f"scene '{scene.name}' of a task must have no moving obstacles: remove them.")
    names = {step.object for step in what.steps if isinstance(step, Pick)}
    fixed = replace(scene_without(scene, names), carried=tuple(item for item in scene.carried if item is not held))
    world = WorldRequest(robot=what.robot, scene=fixed, collision=request.what.collision, margin=request.what.margin)
    checker = make_checker_for(world)
    scene = resolve_frames(scene, checker.robot)
    objects = {item.name: item for item in scene.obstacles if item.name in names}
    modes = Modes(checker, objects, progress=progress)
    if held is not None:
        modes.take(next(item for item in scene.carried if item.name == held.name))
    return scene, modes


def _ends(candidates: Candidates, modes: Modes) -> Floats:
    """Return goals of the roadmap's growth: free ends of lines of all steps, and goals of moves."""
    chosen = []
    for step in sorted(candidates.steps, key=lambda step: NO_OBJECT not in step):  # moves first
        listed = [one for ones in step.values() for one in ones]
        for k in np.unique(np.linspace(0, len(listed) - 1, min(len(listed), _ENDS)).round().astype(int)):
            chosen.append(listed[k].ends[: 1 + len(listed[k].motions)])
    ends = np.vstack(chosen)
    return ends[[contact_at(modes.checker, q) is None for q in ends]]


def explain_failure(candidates: Candidates, search: LazySearch | None) -> StepFails:
    """Return the reason of a failure: a step without candidates, or one that no path completes."""
    dead = candidates.dead_end
    number = dead if dead is not None else search.blocking_step() if search is not None else 0
    number = min(number, len(candidates.task.steps) - 1)
    step, rejected = candidates.task.steps[number], deepcopy(candidates.rejected[number])
    lost = search is not None and not isinstance(step, Move) and _all_blocked(candidates, search, number, rejected)
    what = ("no_grasp" if isinstance(step, Pick) else "no_placement") if dead is not None or lost else "no_path"
    beyond = 0.0
    if 0 < rejected.of == len(rejected.out_of_reach):  # then the distance beyond reach is proven of all
        beyond = min(beyond_reach(candidates.modes.robot, position) for position in rejected.out_of_reach)
    return StepFails(
        step=number + 1,
        doing=step_text(step),
        what=what,
        tried=rejected.of,
        out_of_reach=len(rejected.out_of_reach),
        violations=rejected.violations,
        contacts=dict(rejected.contacts.most_common()),
        conditions=candidates.modes.checker.world.constraints.texts,
        beyond=beyond if beyond >= _LEAST_BEYOND else None,
    )


def _all_blocked(candidates: Candidates, search: LazySearch, number: int, rejected: Rejected) -> bool:
    """Count contacts of a step's candidates; return whether all their lines are refused in every mode."""
    net, hits, has_open = search.tasks, [], False
    for transition in (each for each in net.transitions if each.step == number):
        arcs = search.complete.arcs_along(np.arange(transition.first, transition.last + 1))
        refused = arcs[search.refused[arcs]].tolist()
        has_open = has_open or not refused
        why = (candidates.modes.why(net.modes[net.mode[arc]], int(net.motion[arc])) for arc in refused)
        hits.append((transition.candidate, next((hit for hit in why if hit), None)))
    rejected.count_blocked(hits)
    return bool(hits) and not has_open
