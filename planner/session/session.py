"""A session: robot, scene and roadmap in a world that changes; plans reuse the roadmap."""

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
from planner.query.cells import composite_targets
from planner.query.query import Query, resolve_query, states_of
from planner.query.resolve import resolve_as_is
from planner.query.robots import load_cell
from planner.roadmap.grow import GrowthSettings
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap
from planner.robot.cell import Cell
from planner.robot.clouds import Points, Voxels
from planner.robot.depth_image import DepthImage
from planner.robot.moving import MovingObstacle
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle
from planner.session.live_roadmap import EdgeChanges, LiveRoadmap
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
    """Plan in a world that changes: most of the roadmap survives a change, and the field heals.

        session = planner.Session("panda", "shelf", collision="coal")
        session.plan("start", "goal").path
        session.move("divider", position=[0.1, 0.62, 0.8])
        plan = session.replan()
        plan.path, plan.edges, plan.seconds

    A change of the world reduces the clearance of edges; edges without clearance are proven again when a path uses
    them. Blocked edges stay in memory and return when the obstacle leaves. The roadmap grows only if start and goal are
    disconnected. Equal calls with equal seeds give equal plans. A call that raises does not change the session.
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
        """Open the world; ``roadmap``, or its file, has the same joints; the first plan builds a missing one.

        ``robot`` and ``scene`` are names, files or objects; ``robot`` alone can be the live world of a gate or of
        another session. ``join_motions`` limits the motions that growth checks, by default 8000 per joint.
        ``objective`` and ``options`` are those of :func:`planner.plan`, but ``refinement_rounds`` is 0 by default: a
        plan then takes milliseconds, and each round adds a fraction of a second. Raises :class:`PlannerError` for
        unusable input, and for a law whose field cannot heal.
        """
        reject_unknown(options, OPTIONS, "a session")
        world: LiveWorld | None = None
        self._cell = None if (cell := options.pop("cell", None)) is None else load_cell(cell)
        if self._cell is not None:
            robot, scene = self._cell.robot, self._cell.scene
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
                f"law must heal its field, got {request.quality.law}, which needs strict overestimates: take another."
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
        self._task: tuple[tuple, TaskPlanner] | None = None  # the last request, and its planner
        self._end: Floats | None = None  # end of the last path
        self._steps: Ints = np.zeros(0, dtype=np.int64)  # nodes of the last path

    def __repr__(self) -> str:
        return f"<Session: {self.robot.name} in {self.scene.name}, {self._live.kept or 'no roadmap yet'}>"

    @property
    def scene(self) -> Scene:
        """The current scene, with carried objects."""
        return self.world.scene

    @property
    def robot(self) -> Robot:
        """The current robot, with carried objects."""
        return self.world.robot

    @property
    def checker(self) -> CollisionChecker:
        """The checker of the current world."""
        return self.world.checker

    @property
    def live(self) -> LiveRoadmap:
        """The roadmap with all edges, blocked ones too, in the current world."""
        return self._live.move_to_world(self.world.checker)

    def close(self) -> None:
        """Stop a running call of another thread soon; that call and every later one raises."""
        self._closed.set()

    @property
    def roadmap(self) -> Roadmap:
        """Nodes and edges proven in the current world; :class:`PlannerError` before the first plan."""
        live = self.live
        if live.kept is None:
            raise PlannerError("the session must have a roadmap, got none: plan first, or give one.")
        edges = live.proofs.free
        nodes = np.zeros(len(live.roadmap.nodes), dtype=bool)
        nodes[live.roadmap.edges[edges]] = True
        return live.with_edges(edges).part(nodes, np.ones(int(edges.sum()), dtype=bool))

    def add(self, obstacle: Obstacle | MovingObstacle | Mapping[str, Any]) -> EdgeChanges:
        """Add an obstacle, or a dict with its keys; moving obstacles affect plans with timing only."""
        return self._change(lambda world: world.add(obstacle))

    def move(
        self,
        name: str,
        position: Iterable[float] | None = None,
        rpy: Iterable[float] | None = None,
        quaternion: Iterable[float] | None = None,
    ) -> EdgeChanges:
        """Move the obstacle ``name`` to a ``position`` (m) and ``rpy`` (rad) or ``quaternion`` (x, y, z, w).

        Omitted values stay. A ``position`` can be a whole pose, (4, 4) or ``pinocchio.SE3``.
        """
        return self._change(lambda world: world.move(name, position, rpy, quaternion))

    def remove(self, name: str) -> EdgeChanges:
        """Remove the obstacle ``name``."""
        return self._change(lambda world: world.remove(name))

    def see(
        self,
        name: str,
        seen: Points | Voxels | DepthImage,
        placement: Floats | None = None,
        q: Floats | None = None,
        margin: float = 0.02,
    ) -> EdgeChanges:
        """Replace the data of the sensor ``name``, at a ``placement`` (4, 4) in the world.

        A depth image has its own placement. Where the arm stood at ``q`` (dof,) when it was seen, what is within
        ``margin`` (m) of it is left out. Blocks of a cloud that are as before cost no proof.
        """
        return self._change(lambda world: world.see(name, seen, placement, q, margin))

    def attach(self, name: str, frame: str, touch_links: Sequence[str] = (), at: object = None) -> EdgeChanges:
        """Attach the obstacle ``name`` to ``frame``; it may touch ``touch_links`` and the link of the frame.

        ``at`` is the robot's state then, by default the end of the last path.
        """
        return self._change(lambda world: world.attach(name, frame, self._resolve_state(at), touch_links))

    def detach(self, name: str, at: object = None) -> EdgeChanges:
        """Detach a carried object: it stays at its pose, and links that were allowed to touch it stay allowed.

        ``at`` is the robot's state then, by default the end of the last path.
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
        """Plan from ``start`` to ``goal``, each a target text or joint values; return the path and its motion.

        ``timing`` None returns the path only, in milliseconds. ``beta`` replaces that of the session. Raises
        :class:`StateError` for an unusable start or goal, :class:`OptionError` for a beta out of range, and
        :class:`PlannerError` when ``progress`` requests a stop.

        If obstacles move along known motions, the plan is the earliest motion among them, with waits: from rest at the
        scene's time 0, along edges from rest to rest, to a goal where the arm can stay. Without ``timing`` moving
        obstacles are ignored. Raises :class:`SceneError` for a session with a floor, which such a motion cannot keep.
        """
        with self._lock():
            planning = self._make_settings(start, goal, beta, timing, progress)
            return self._answer(planning, _resolve(self.checker, planning.request, self._cell))

    def replan(self, *, progress: Progress = QUIET) -> SessionPlan:
        """Solve the last query again in the current world; :class:`PlannerError` before the first plan.

        Configurations of a start or goal that are still free stay the same. ``progress`` is as in :meth:`plan`.
        """
        with self._lock():
            if self._last_query is None:
                raise PlannerError("replan must follow a plan, got none: call plan(start, goal) first.")
            settings, query = self._last_query
            planning = self._with_stop(settings, progress)
            checker = self.checker
            query = _keep_free_ends(checker, query) or _resolve(checker, planning.request, self._cell)
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
        """Plan a task, or steps, in the current world, from the current state of arm and hand.

            plan = session.task([Pick("mug"), Place("mug", "board", ((0.4, 0.1), (0.7, 0.3))), Move("home")])

        Robot and scene are those of the session, also for a :class:`planner.Task` or its file. ``start`` is the state
        of the arm, by default the end of the last path, or else the start of the task. The first step can place a
        carried object. ``options`` are fields of :class:`planner.TaskRequest` and replace those of the session. The
        same task in the same world, from any start and at any beta, reuses its roadmap and proofs. Raises as
        :func:`planner.task`, and :class:`SceneError` for a session with a floor, which a task cannot keep.
        """
        with self._lock():
            plain = self._planning.request
            if plain.quality.min_manipulability > 0:
                raise SceneError("min_manipulability must be 0 for tasks: make a session without a floor.")
            own = TaskRequest.from_options(**{name: plain.values()[name] for name in _OF_TASKS})
            beta = options.pop("beta", plain.quality.beta)
            request, progress = own.with_options(**options), self._with_stop(self._planning, progress).progress
            q = self._end if start is None else self._resolve_state(start, "start")
            task = Task.load(file) if isinstance(file, str | PathLike) else file
            key = self.scene, task if isinstance(task, Task) else tuple(task), request, q is None
            if self._task is None or self._task[0] != key:
                self._task = key, TaskPlanner.from_task(_make_task(self.world, task, q), request, progress)
                q = None
            return self._task[1].plan(beta, q, timing=timing, progress=progress)

    def holds(self) -> bool:
        """Whether the last path is proven free in the current world; faster than a plan. False without a path."""
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
        """Return the settings of a query."""
        request = self._planning.request
        beta = request.quality.beta if beta is None else beta
        request = request.with_options(start=start, goal=goal, beta=beta)
        return self._with_stop(replace(self._planning, request=request, timing=timing), progress)

    def _with_stop(self, planning: PlanningSettings, progress: Progress) -> PlanningSettings:
        """Return settings that also stop when the session is closed or ``progress`` requests a stop."""
        return replace(planning, progress=Progress(progress, lambda: self._closed.is_set() or progress.stopped))

    def _change(self, apply: Callable[[LiveWorld], None]) -> EdgeChanges:
        """Change the world; return the changes of the roadmap's edges."""
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
            raise StateError(f"{role} must be a state if there is no last path: give {role}=.")
        return self._end

    @contextmanager
    def _lock(self) -> Iterator[None]:
        """Refuse a second call while another runs."""
        if not self._busy.acquire(blocking=False):
            raise PlannerError("a session runs one call at a time: wait for the other, or make a session per thread.")
        try:
            yield
        finally:
            self._busy.release()


def _resolve(checker: CollisionChecker, request: PlanRequest, cell: Cell | None) -> Query:
    what, how = request.what, (request.what.ik_solutions, request.what.ik_tolerance)
    ends = (what.start, what.goal) if cell is None else composite_targets(cell, what.start, what.goal, *how)
    query = resolve_query(checker, *ends, *how)
    return query if cell is None else query.with_texts(what.goal)


def _make_task(world: LiveWorld, what: Task | Sequence[Step], q: Floats | None) -> Task:
    """Return a task, or steps, as a task in the current world, from ``q`` (dof,) if given."""
    now = world.checker.world
    scene = replace(now.scene, constraints=AND.join(each.text for each in now.conditions))
    task = what if isinstance(what, Task) else Task(world.bare, scene, tuple(what))
    return replace(task, robot=world.bare, scene=scene, start=task.start if q is None else joints_text(q.tolist()))


def _keep_free_ends(checker: CollisionChecker, query: Query) -> Query | None:
    """Return the query with its free configurations; None if no start or no goal is free."""
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
