"""A robot, a scene and a roadmap that live together: the world changes, and paths are found again."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any, NoReturn

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError, PlannerError, SceneError, StateError
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker, is_free
from planner.planning.plan import require_no_floor
from planner.planning.replanned import Change
from planner.planning.result import Plan
from planner.planning.why_no_path import why_no_path
from planner.problem.conditions import AND
from planner.problem.objective import Objective
from planner.problem.options import RobotLike
from planner.problem.request import PlanRequest, TaskRequest, TimingRequest, require_known, with_objective
from planner.problem.targets import joints_text, target_of
from planner.query.query import Query, resolve_query, states_of
from planner.query.resolve import resolve_as_is
from planner.roadmap.growth_settings import GrowthSettings
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap
from planner.robot.moving import MovingObstacle
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle
from planner.session.answer import Moment, Planning, adopted, answered
from planner.session.in_time import planned_in_time
from planner.session.live_world import LiveWorld
from planner.session.search import go_on, prove_path
from planner.tasks.file import Step, Task
from planner.tasks.plan import TaskPlanner
from planner.tasks.result import TaskPlan
from planner.trajectory.limits import MotionLimits, own_limits

_OF_A_PLAN = (
    *("robot", "scene", "start", "goal", "motion_plan_request", "widen_limits"),
    *("roadmap", "room", "beta", "approach", "retreat", "path_only"),
)
OPTIONS = tuple(name for name in PlanRequest.names() if name not in _OF_A_PLAN)
_OF_TASKS = ("seed", "beta", "collision", "margin", "law", "prescribed_time", "metric", "manipulability_cost")


@dataclass(frozen=True, eq=False)
class Snapshot:
    """All that a session knows at one moment, see :meth:`Session.snapshot`."""

    of: Session
    now: Moment
    asked: tuple[Planning, Query] | None
    end: Floats | None
    steps: Ints


class Session:
    """Plans in a world that changes, without beginning anew: most of a roadmap survives a change, and the field heals.

        session = planner.Session("panda", "shelf", collision="coal")
        session.plan("start", "goal").path
        session.move("divider", position=[0.1, 0.62, 0.8])
        plan = session.replan()
        plan.path, plan.edges, plan.seconds

    Edges are proven again where a change spends their clearance, and only once a path is to use them. What an obstacle
    blocks is kept, and regained when it goes. The roadmap grows only where start and goal have come apart. The same
    calls with the same seed give the same answers. A call that raises leaves the session as it was.
    """

    def __init__(
        self,
        robot: RobotLike,
        scene: RobotLike,
        roadmap: Roadmap | StrPath | None = None,
        *,
        join_motions: int | None = None,
        objective: Objective | None = None,
        **options: Any,
    ) -> None:
        """``roadmap``, or its file, of the same joints in any scene; without one the first plan builds it.

        ``join_motions``: how many motions growth may check before it gives up, 8000 per joint where left out.
        ``objective`` and ``options`` are those of :func:`planner.plan`, but for ``effort``: 0 where left out, so that
        a plan is there in milliseconds; each round of more refines its path for a good part of a second. Raises
        :class:`PlannerError` for unusable input, a law that cannot heal included.
        """
        require_known(options, OPTIONS, "a session")
        request = PlanRequest.from_options(robot=robot, scene=scene, effort=0, room=0.0).with_options(**options)
        if objective is not None:
            request = with_objective(request, objective, options)
        dynamics = gabf.named_law(request.quality.law, request.quality.prescribed_time)
        if dynamics.needs_overestimate:
            raise OptionError(
                f"the {request.quality.law} law needs strict overestimates, so its field cannot heal: take another law."
            )
        self._busy, self._closed = threading.Lock(), threading.Event()
        growth = GrowthSettings(join_motions=join_motions, floor=request.quality.min_manipulability)
        self._planning = Planning(request, dynamics, growth, Progress(stop=self._closed.is_set))
        live = LiveWorld.of(request.what)
        if roadmap is not None:
            live = adopted(live, roadmap if isinstance(roadmap, Roadmap) else load_roadmap(roadmap))
        self._now = Moment(live, np.zeros(0))
        self._asked: tuple[Planning, Query] | None = None
        self._task: tuple[tuple, TaskPlanner] | None = None  # the last one, and what it was asked
        self._end: Floats | None = None  # where the last path ends
        self._steps: Ints = np.zeros(0, dtype=np.int64)  # and the nodes it goes over

    def __repr__(self) -> str:
        world, kept = self._now.live.world, self._now.live.kept
        return f"<Session: {world.robot.name} in {world.scene.name}, {kept or 'no roadmap yet'}>"

    @property
    def scene(self) -> Scene:
        """The scene as it is now, with what the arm carries."""
        return self._now.live.scene

    @property
    def robot(self) -> Robot:
        """The robot with what it carries now."""
        return self._now.live.checker.robot

    @property
    def checker(self) -> CollisionChecker:
        """The checker of the world as it is now."""
        return self._now.live.checker

    @property
    def live(self) -> LiveWorld:
        """The world as it is now, with what is known of every edge, blocked ones included."""
        return self._now.live

    def close(self) -> None:
        """End what is under way in another thread, as soon as can be: that call, and every later one, raises."""
        self._closed.set()

    def __reduce__(self) -> NoReturn:
        raise TypeError("a session stays in its process and is no copy of another: make one of its robot and scene.")

    def snapshot(self) -> Snapshot:
        """What the session knows now, for :meth:`restore`; it costs nothing, as nothing in it ever changes."""
        return Snapshot(self, self._now, self._asked, self._end, self._steps)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to an earlier moment of this session: its world, its roadmap, its field and its last question.

        Raises :class:`PlannerError` for a snapshot of another session.
        """
        with self._alone():
            if snapshot.of is not self:
                raise PlannerError("the snapshot is of another session: restore it in the one that handed it out.")
            self._now, self._asked = snapshot.now, snapshot.asked
            self._end, self._steps = snapshot.end, snapshot.steps

    @property
    def roadmap(self) -> Roadmap:
        """Nodes and edges that are proven in the world as it is now; :class:`PlannerError` before the first plan."""
        live = self._now.live
        if live.kept is None:
            raise PlannerError("the session has no roadmap yet: plan first, or give it one.")
        edges = live.proofs.free
        nodes = np.zeros(len(live.roadmap.nodes), dtype=bool)
        nodes[live.roadmap.edges[edges]] = True
        return live.held(edges).part(nodes, np.ones(int(edges.sum()), dtype=bool))

    def add(self, obstacle: Obstacle | MovingObstacle) -> Change:
        """Put an obstacle into the world; one that moves matters to :meth:`plan_in_time` only."""
        return self._change(f"obstacle '{obstacle.name}' added", lambda live: live.add(obstacle))

    def move(
        self,
        name: str,
        position: Iterable[float] | None = None,
        rpy: Iterable[float] | None = None,
        quaternion: Iterable[float] | None = None,
    ) -> Change:
        """Put the obstacle ``name`` to a ``position`` (m), turned by ``rpy`` (rad) or ``quaternion`` [x, y, z, w].

        What is left out stays as it is.
        """
        given = {"position": position, "rpy": rpy, "quaternion": quaternion}
        data = {key: np.asarray(value).tolist() for key, value in given.items() if value is not None}
        return self._change(f"obstacle '{name}' moved", lambda live: live.move(name, data))

    def remove(self, name: str) -> Change:
        """Take the obstacle ``name`` out of the world."""
        return self._change(f"obstacle '{name}' removed", lambda live: live.remove(name))

    def attach(self, name: str, frame: str, touch_links: Sequence[str] = (), at: object = None) -> Change:
        """Let ``frame`` carry the obstacle ``name``, which may touch ``touch_links`` and the link itself.

        ``at`` is the state in which the arm takes it; left out, the end of the last path.
        """
        return self._change(
            f"'{name}' attached to '{frame}'",
            lambda live: live.attach(name, frame, tuple(touch_links), self._held_at(live, at)),
        )

    def detach(self, name: str, at: object = None) -> Change:
        """Let go of what is carried: it stays where the arm holds it, and the links that might touch it still may.

        ``at`` is the state in which the arm lets go; left out, the end of the last path.
        """
        return self._change(f"'{name}' detached", lambda live: live.detach(name, self._held_at(live, at)))

    def plan(
        self, start: object = "start", goal: object = "goal", beta: float | None = None, progress: Progress = QUIET
    ) -> Plan:
        """A path from ``start`` to ``goal``, written as everywhere, or joint values.

        ``beta`` takes the place of the session's own. Raises :class:`StateError` where one of them cannot be used,
        :class:`OptionError` for a beta out of range, and :class:`PlannerError` once ``progress`` is asked to stop.
        """
        with self._alone():
            planning = self._watched(self._asking(start, goal, beta), progress)
            return self._answer(planning, _resolved(self._now.live, planning.request))

    def replan(self, progress: Progress = QUIET) -> Plan:
        """The last question once more, in the world as it is now; :class:`PlannerError` where none was asked.

        Of a start or goal that is a tool position, the configurations stay that are still free. ``progress`` as of
        :meth:`plan`.
        """
        with self._alone():
            if self._asked is None:
                raise PlannerError("nothing was asked yet: call plan(start, goal) first.")
            asked, query = self._asked
            planning = self._watched(asked, progress)
            query = _still_free(self._now.live, query) or _resolved(self._now.live, planning.request)
            return self._answer(planning, query)

    def task(
        self,
        what: Task | StrPath | Sequence[Step],
        start: object = None,
        progress: Progress = QUIET,
        timing: TimingRequest | None = None,
        **options: Any,
    ) -> TaskPlan:
        """Plan a task, or steps, in the world as it is now: from where the arm is, holding what it holds.

            found = session.task([Pick("mug"), StrPath("mug", Region("board", ((0.4, 0.1), (0.7, 0.3)))), Move("home")])

        Of a :class:`planner.Task`, or its file, robot and scene are the session's. ``start`` is where the arm is; left
        out, the end of the session's last path, and without one where the task begins. What the arm carries may be
        placed first. ``options`` are fields of :class:`planner.TaskRequest`, in place of the session's. The same
        question in the same world, from any start and at any beta, is answered on what is known. Raises as
        :func:`planner.task`, and :class:`SceneError` where the session has a floor, which no task keeps to.
        """
        with self._alone():
            plain, live = self._planning.request, self._now.live
            if plain.quality.min_manipulability > 0:
                raise SceneError("the session keeps a floor under manipulability, which no task does: leave it out.")
            own = TaskRequest.from_options(**{name: plain.values()[name] for name in _OF_TASKS})
            beta = options.pop("beta", plain.quality.beta)
            request, progress = own.with_options(**options), self._watched(self._planning, progress).progress
            q = self._end if start is None else self._held_at(live, start, "start")
            asked = Task.load(what) if isinstance(what, str | PathLike) else what
            key = live.scene, asked if isinstance(asked, Task) else tuple(asked), request, q is None
            if self._task is None or self._task[0] != key:
                self._task = key, TaskPlanner.of(_task_in(live, asked, q), request, progress)
                q = None
            return self._task[1].plan(beta, q, progress, timing)

    def holds(self) -> bool:
        """Whether the last answer's path is free in the world as it is now, proven as it was then; quicker than a plan.

        False where there is none.
        """
        with self._alone():
            if not len(self._steps):
                return False
            live, holds = prove_path(self._now.live, self._steps, around_too=False)
            self._now = replace(self._now, live=live)
            return holds

    def plan_in_time(self, start: object = "start", goal: object = "goal", limits: MotionLimits | None = None) -> Plan:
        """The earliest motion from ``start`` to ``goal`` among obstacles along known motions, waiting included.

        It begins at rest at the scene's time 0, runs the roadmap's edges from rest to rest within ``limits`` (the
        robot's own where left out), waits at nodes, and ends where it can stay. Its proof says until when obstacles
        with a speed limit cannot touch it. Raises as :meth:`plan`, and :class:`SceneError` where the session has a
        floor, which no motion in time keeps to.
        """
        with self._alone():
            planning = self._asking(start, goal, 1.0)
            require_no_floor(planning.request)
            query = _resolved(self._now.live, planning.request)
            now, alone = answered(self._now, query, planning)
            live, timed = planned_in_time(now.live, alone, own_limits(limits, self.robot))
            self._now = replace(now, live=replace(live, stands=query.starts))
            self._end, self._steps = timed.path[-1] if timed.solved else None, timed.path_nodes
            return timed

    def _answer(self, planning: Planning, query: Query) -> Plan:
        now, answer = answered(self._now, query, planning)
        if not answer.solved:
            failed = replace(answer, roadmap=now.live.held(now.live.proofs.free))
            answer = replace(answer, reason=why_no_path(failed, planning.progress))
            go_on(planning.progress)
        self._now = replace(now, live=replace(now.live, stands=query.starts))
        self._asked = self._watched(planning, QUIET), query
        self._end, self._steps = answer.path[-1] if answer.solved else None, answer.path_nodes
        return answer

    def _asking(self, start: object, goal: object, beta: float | None) -> Planning:
        """How the session plans this question."""
        plain = self._planning.request
        beta = plain.quality.beta if beta is None else beta
        request = plain.with_options(start=start, goal=goal, beta=beta)
        return replace(self._planning, request=request)

    def _watched(self, planning: Planning, progress: Progress) -> Planning:
        """The same, for one who watches and may stop it."""
        return replace(planning, progress=Progress(progress, lambda: self._closed.is_set() or progress.stopped))

    def leave(self) -> None:
        """Let the arm stand nowhere until it plans again, so that a change may put something where it stood."""
        with self._alone():
            live = self._now.live
            self._now = replace(self._now, live=replace(live, stands=live.stands[:0]))

    def _change(self, what: str, apply: Callable[[LiveWorld], LiveWorld]) -> Change:
        with self._alone():
            go_on(self._planning.progress)
            begin, before = time.perf_counter(), self._now.live
            after = apply(before)
            self._now = replace(self._now, live=after)
            edges = after.proofs.since(before.proofs, checked=False)
            return Change(what, edges, time.perf_counter() - begin)

    def _held_at(self, live: LiveWorld, at: object, role: str = "at") -> Floats:
        if at is not None:
            return resolve_as_is(target_of(at), live.checker, states_of(live.bare, live.scene), role)
        if self._end is None:
            raise StateError("no path has been planned at whose end the arm stands: say where it is with at=.")
        return self._end

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """One call at a time: a second one is refused, it does not wait."""
        if not self._busy.acquire(blocking=False):
            raise PlannerError("the session is busy with another call: wait for that, or make a session per thread.")
        try:
            yield
        finally:
            self._busy.release()


def _resolved(live: LiveWorld, request: PlanRequest) -> Query:
    what = request.what
    return resolve_query(live.checker, what.start, what.goal, what.ik_solutions, what.ik_tolerance)


def _task_in(live: LiveWorld, what: Task | Sequence[Step], q: Floats | None) -> Task:
    """A task, or steps, by the robot in the world as it is now, from ``q`` (dof,) where that is given."""
    scene = replace(live.scene, keep=AND.join(each.text for each in live.world.conditions))
    task = what if isinstance(what, Task) else Task(live.bare, scene, tuple(what))
    return replace(task, robot=live.bare, scene=scene, start=task.start if q is None else joints_text(q.tolist()))


def _still_free(live: LiveWorld, query: Query) -> Query | None:
    """The query's configurations that are free; None where no start or no goal is."""
    starts, goals = (np.array([is_free(live.checker, q) for q in ends]) for ends in (query.starts, query.goals))
    if not (starts.any() and goals.any()):
        return None
    names = tuple(name for name, free in zip(query.goal_names, goals, strict=True) if free)
    return replace(
        query,
        checker=live.checker,
        scene=live.scene,
        robot=live.checker.robot,
        starts=query.starts[starts],
        goals=query.goals[goals],
        goal_names=names,
    )
