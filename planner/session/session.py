"""A robot, a scene and a roadmap that live together: the world changes, and paths are found again."""

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.errors import OptionError, PlannerError, SceneError, StateError
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker, is_free
from planner.problem.conditions import AND
from planner.problem.options import ROBOT, SCENE, RobotLike, SceneLike
from planner.problem.request import Objective, PlanRequest, TaskRequest, TimingRequest, build_request, reject_unknown
from planner.problem.targets import joints_text, read_target
from planner.query.query import Query, resolve_query, states_of
from planner.query.resolve import resolve_as_is
from planner.roadmap.grow import GrowthSettings
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap
from planner.robot.moving import MovingObstacle
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle
from planner.session.live_roadmap import Edges, LiveRoadmap
from planner.session.live_world import LiveWorld
from planner.session.solve import PlanningSettings, SessionPlan, prove_path, raise_if_stopped, solve_query
from planner.tasks.plan import TaskPlanner
from planner.tasks.result import TaskPlan
from planner.tasks.task import Step, Task

_OF_A_PLAN = (
    *("robot", "scene", "start", "goal", "motion_plan_request", "widen_limits"),
    *("roadmap", "extra_clearance", "beta", "approach", "retreat", "path_only"),
)
OPTIONS = tuple(name for name in PlanRequest.names() if name not in _OF_A_PLAN)
_OF_TASKS = ("seed", "beta", "collision", "margin", "law", "prescribed_time", "metric", "manipulability_cost")


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
        robot: RobotLike | LiveWorld = ROBOT,
        scene: SceneLike = SCENE,
        *,
        objective: Objective | None = None,
        roadmap: Roadmap | StrPath | None = None,
        join_motions: int | None = None,
        **options: Any,
    ) -> None:
        """``roadmap``, or its file, of the same joints in any scene; without one the first plan builds it.

        ``robot`` and ``scene`` by name, file or as loaded, or the live world of a gate or of another session alone.
        ``join_motions``: how many motions growth may check before it gives up, 8000 per joint where left out.
        ``objective`` and ``options`` are those of :func:`planner.plan`, but for ``refinement_rounds``: 0 where left
        out, so that a plan is there in milliseconds; each round of more refines its path for a good part of a second.
        Raises :class:`PlannerError` for unusable input, a law that cannot heal included.
        """
        reject_unknown(options, OPTIONS, "a session")
        world: LiveWorld | None = None
        if isinstance(robot, LiveWorld):
            world, now = robot, robot.checker.world
            options |= {"collision": robot.checker.name, "margin": now.margin, "constraint": now.conditions}
            robot, scene = robot.bare, robot.scene
        request = build_request(
            PlanRequest.from_options(refinement_rounds=0, extra_clearance=0.0), objective, options, robot, scene
        )
        dynamics = gabf.law_from_name(request.quality.law, request.quality.prescribed_time)
        if dynamics.needs_overestimate:
            raise OptionError(
                f"the {request.quality.law} law needs strict overestimates, so its field cannot heal: take another law."
            )
        self._busy, self._closed = threading.Lock(), threading.Event()
        growth = GrowthSettings(join_motions=join_motions, floor=request.quality.min_manipulability)
        self._planning = PlanningSettings(request, dynamics, growth, Progress(stop=self._closed.is_set))
        self.world = LiveWorld(request.what) if world is None else world
        self._live = LiveRoadmap.from_checker(self.world.checker)
        if roadmap is not None:
            given = roadmap if isinstance(roadmap, Roadmap) else load_roadmap(roadmap)
            self._live = self._live.with_foreign_roadmap(given)
        self._last_query: tuple[PlanningSettings, Query] | None = None
        self._task: tuple[tuple, TaskPlanner] | None = None  # the last one, and what it was asked
        self._end: Floats | None = None  # where the last path ends
        self._steps: Ints = np.zeros(0, dtype=np.int64)  # and the nodes it goes over

    def __repr__(self) -> str:
        return f"<Session: {self.robot.name} in {self.scene.name}, {self._live.kept or 'no roadmap yet'}>"

    @property
    def scene(self) -> Scene:
        """The scene as it is now, with what the arm carries."""
        return self.world.scene

    @property
    def robot(self) -> Robot:
        """The robot with what it carries now."""
        return self.world.robot

    @property
    def checker(self) -> CollisionChecker:
        """The checker of the world as it is now."""
        return self.world.checker

    @property
    def live(self) -> LiveRoadmap:
        """What is known of every edge in the world as it is now, of blocked ones too."""
        return self._live.move_to_world(self.world.checker)

    def close(self) -> None:
        """End what is under way in another thread, as soon as can be: that call, and every later one, raises."""
        self._closed.set()

    @property
    def roadmap(self) -> Roadmap:
        """Nodes and edges that are proven in the world as it is now; :class:`PlannerError` before the first plan."""
        live = self.live
        if live.kept is None:
            raise PlannerError("the session has no roadmap yet: plan first, or give it one.")
        edges = live.proofs.free
        nodes = np.zeros(len(live.roadmap.nodes), dtype=bool)
        nodes[live.roadmap.edges[edges]] = True
        return live.with_edges(edges).part(nodes, np.ones(int(edges.sum()), dtype=bool))

    def add(self, obstacle: Obstacle | MovingObstacle | Mapping[str, Any]) -> Edges:
        """Put an obstacle into the world, a dict too; one that moves matters to plans in time only."""
        return self._change(lambda world: world.add(obstacle))

    def move(
        self,
        name: str,
        position: Iterable[float] | None = None,
        rpy: Iterable[float] | None = None,
        quaternion: Iterable[float] | None = None,
    ) -> Edges:
        """Put the obstacle ``name`` to a ``position`` (m), turned by ``rpy`` (rad) or ``quaternion`` [x, y, z, w].

        What is left out stays as it is. A pose, (4, 4) or ``pinocchio.SE3``, in place of the position gives all of it.
        """
        return self._change(lambda world: world.move(name, position, rpy, quaternion))

    def remove(self, name: str) -> Edges:
        """Take the obstacle ``name`` out of the world."""
        return self._change(lambda world: world.remove(name))

    def attach(self, name: str, frame: str, touch_links: Sequence[str] = (), at: object = None) -> Edges:
        """Let ``frame`` carry the obstacle ``name``, which may touch ``touch_links`` and the link itself.

        ``at`` is the state in which the arm takes it; left out, the end of the last path.
        """
        return self._change(lambda world: world.attach(name, frame, self._resolve_state(at), touch_links))

    def detach(self, name: str, at: object = None) -> Edges:
        """Let go of what is carried: it stays where the arm holds it, and the links that might touch it still may.

        ``at`` is the state in which the arm lets go; left out, the end of the last path.
        """
        return self._change(lambda world: world.detach(name, self._resolve_state(at)))

    def plan(
        self,
        start: object = "start",
        goal: object = "goal",
        *,
        beta: float | None = None,
        timing: TimingRequest | None = TimingRequest(),  # noqa: B008 (frozen)
        progress: Progress = QUIET,
    ) -> SessionPlan:
        """A path from ``start`` to ``goal``, written as everywhere, or joint values, and its motion in ``timing``.

        ``timing`` None gives the path only, in milliseconds. ``beta`` takes the place of the session's own. Raises
        :class:`StateError` where one of them cannot be used, :class:`OptionError` for a beta out of range, and
        :class:`PlannerError` once ``progress`` is asked to stop.

        Where obstacles move along known motions the plan is the earliest motion among them, waiting included: from rest
        at the scene's time 0, along edges from rest to rest, to where the arm can stay. Without ``timing`` they do not
        matter. Raises :class:`SceneError` then where the session has a floor, which no such motion keeps to.
        """
        with self._lock():
            planning = self._make_settings(start, goal, beta, timing, progress)
            return self._answer(planning, _resolve(self.checker, planning.request))

    def replan(self, *, progress: Progress = QUIET) -> SessionPlan:
        """The last question again, in the world as it is now; :class:`PlannerError` where none was asked.

        Of a start or goal that is a tool position, the configurations stay that are still free. ``progress`` as of
        :meth:`plan`.
        """
        with self._lock():
            if self._last_query is None:
                raise PlannerError("nothing was asked yet: call plan(start, goal) first.")
            asked, query = self._last_query
            planning = self._with_stop(asked, progress)
            checker = self.checker
            query = _keep_free_ends(checker, query) or _resolve(checker, planning.request)
            return self._answer(planning, query)

    def task(
        self,
        file: Task | StrPath | Sequence[Step],
        *,
        start: object = None,
        timing: TimingRequest | None = TimingRequest(),  # noqa: B008
        progress: Progress = QUIET,
        **options: Any,
    ) -> TaskPlan:
        """Plan a task, or steps, in the world as it is now: from where the arm is, holding what it holds.

            found = session.task([Pick("mug"), Place("mug", "board", ((0.4, 0.1), (0.7, 0.3))), Move("home")])

        Of a :class:`planner.Task`, or its file, robot and scene are the session's. ``start`` is where the arm is; left
        out, the end of the session's last path, and without one where the task begins. What the arm carries may be
        placed first. ``options`` are fields of :class:`planner.TaskRequest`, in place of the session's. The same
        question in the same world, from any start and at any beta, is answered on what is known. Raises as
        :func:`planner.task`, and :class:`SceneError` where the session has a floor, which no task keeps to.
        """
        with self._lock():
            plain = self._planning.request
            if plain.quality.min_manipulability > 0:
                raise SceneError("the session keeps a floor under manipulability, which no task does: leave it out.")
            own = TaskRequest.from_options(**{name: plain.values()[name] for name in _OF_TASKS})
            beta = options.pop("beta", plain.quality.beta)
            request, progress = own.with_options(**options), self._with_stop(self._planning, progress).progress
            q = self._end if start is None else self._resolve_state(start, "start")
            asked = Task.load(file) if isinstance(file, str | PathLike) else file
            key = self.scene, asked if isinstance(asked, Task) else tuple(asked), request, q is None
            if self._task is None or self._task[0] != key:
                self._task = key, TaskPlanner.from_task(_make_task(self.world, asked, q), request, progress)
                q = None
            return self._task[1].plan(beta, q, timing=timing, progress=progress)

    def holds(self) -> bool:
        """Whether the last answer's path is free in the world as it is now, proven as it was then; quicker than a plan.

        False where there is none.
        """
        with self._lock():
            if not len(self._steps):
                return False
            self._live, holds = prove_path(self.live, self._steps, around_too=False)
            return holds

    def _answer(self, planning: PlanningSettings, query: Query) -> SessionPlan:
        live, answer = solve_query(self._live.move_to_world(query.checker), query, planning)
        self._live, self._last_query = live, (self._with_stop(planning, QUIET), query)
        self._end, self._steps = answer.path[-1] if answer.solved else None, answer.path_nodes
        return answer

    def _make_settings(
        self, start: object, goal: object, beta: float | None, timing: TimingRequest | None, progress: Progress
    ) -> PlanningSettings:
        """How the session plans this question."""
        plain = self._planning.request
        beta = plain.quality.beta if beta is None else beta
        request = plain.with_options(start=start, goal=goal, beta=beta)
        return self._with_stop(replace(self._planning, request=request, timing=timing), progress)

    def _with_stop(self, planning: PlanningSettings, progress: Progress) -> PlanningSettings:
        """The same, until the session is closed or ``progress`` asks for a stop."""
        return replace(planning, progress=Progress(progress, lambda: self._closed.is_set() or progress.stopped))

    def _change(self, apply: Callable[[LiveWorld], None]) -> Edges:
        """Change the world; what the change means for the roadmap's edges."""
        with self._lock():
            raise_if_stopped(self._planning.progress)
            before = self.live
            apply(self.world)
            self._live = before.move_to_world(self.checker)
            return self._live.proofs.since(before.proofs, checked=False)

    def _resolve_state(self, at: object, role: str = "at") -> Floats:
        if at is not None:
            return resolve_as_is(read_target(at), self.checker, states_of(self.world.bare, self.scene), role)
        if self._end is None:
            raise StateError("no path has been planned at whose end the arm stands: say where it is with at=.")
        return self._end

    @contextmanager
    def _lock(self) -> Iterator[None]:
        """One call at a time: a second one is refused, it does not wait."""
        if not self._busy.acquire(blocking=False):
            raise PlannerError("the session is busy with another call: wait for that, or make a session per thread.")
        try:
            yield
        finally:
            self._busy.release()


def _resolve(checker: CollisionChecker, request: PlanRequest) -> Query:
    what = request.what
    return resolve_query(checker, what.start, what.goal, what.ik_solutions, what.ik_tolerance)


def _make_task(world: LiveWorld, what: Task | Sequence[Step], q: Floats | None) -> Task:
    """A task, or steps, by the robot in the world as it is now, from ``q`` (dof,) where that is given."""
    now = world.checker.world
    scene = replace(now.scene, constraints=AND.join(each.text for each in now.conditions))
    task = what if isinstance(what, Task) else Task(world.bare, scene, tuple(what))
    return replace(task, robot=world.bare, scene=scene, start=task.start if q is None else joints_text(q.tolist()))


def _keep_free_ends(checker: CollisionChecker, query: Query) -> Query | None:
    """The query's configurations that are free; None where no start or no goal is."""
    starts, goals = (np.array([is_free(checker, q) for q in ends]) for ends in (query.starts, query.goals))
    if not (starts.any() and goals.any()):
        return None
    return replace(
        query,
        checker=checker,
        scene=checker.world.scene,
        robot=checker.robot,
        starts=query.starts[starts],
        goals=query.goals[goals],
        goal_names=tuple(name for name, free in zip(query.goal_names, goals, strict=True) if free),
    )
