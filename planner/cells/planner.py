"""Plans of the robots of a cell in turn: a roadmap of each, and a search for who moves when."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError, StateError
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.cells.coordinate import coordinate
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.forward import Chain, joint_placements
from planner.planning.result import Plan
from planner.planning.solve import find_path, time_plan, why_no_path
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, TimingRequest, reject_unknown
from planner.query.cells import composite_targets, make_robot_checker
from planner.query.query import Query, resolve_query
from planner.query.robots import load_cell
from planner.roadmap.build import roadmap_of_path
from planner.roadmap.edges import MotionChecker
from planner.roadmap.load_or_build import load_or_build_roadmap
from planner.roadmap.roadmap import Roadmap
from planner.robot.cell import Cell
from planner.robot.robot import with_carried
from planner.robot.shapes import Obstacle
from planner.session.session import Session
from planner.trajectory.limits import MotionLimits

OPTIONS = (
    *("seed", "nodes", "beta", "collision", "margin", "metric", "manipulability_cost", "law", "prescribed_time"),
    "refinement_rounds",
)
_FEW = 2  # robots whose orders are all tried before the composite is searched
_ORDERS = 6  # orders of more robots


class CellPlanner:
    """Plans of several robots in turn, with a roadmap of each that is kept from call to call.

        cell_planner = planner.CellPlanner(cell, nodes=200)
        plan = cell_planner.plan(start="here", goal="there")
        plan.trajectory, plan.trajectories["left"], plan.makespan, plan.flowtime

    Every robot has a session with a roadmap among the obstacles and the links that the others never move; ``beta`` and
    the field act on it as for one arm. The attempts, until one is proven: each robot on its own path, some waiting; in
    an order, each past the others at rest, then moved at once where that is proven; one tree of all joints. Every plan
    is proven as a motion of the composite, with all pairs of links of two robots.
    """

    def __init__(self, cell: Cell | StrPath, **options: Any) -> None:
        """Open the cell; ``options`` are those of :func:`planner.plan` that ``OPTIONS`` lists.

        Raises :class:`PlannerError` for a cell that cannot be used, and for moving obstacles: plan the composite.
        """
        reject_unknown(options, OPTIONS, "a cell planner")
        self.cell = load_cell(cell if isinstance(cell, Cell) else str(cell))
        if self.cell.scene.moving or self.cell.scene.constraints:
            raise OptionError(
                "a cell that is planned in turn must have no moving obstacles and no constraints: plan it together."
            )
        own = {name: value for name, value in options.items() if name != "nodes"}  # nodes are of each robot's roadmap
        quality = {"in_turn": True, "path_only": True, "refinement_rounds": 0, "extra_clearance": 0.0}
        self.request = PlanRequest.from_options(cell=cell, **(quality | own))
        robot, margin = with_carried(self.cell.robot, self.cell.scene.carried), self.request.what.margin
        self.checker: CollisionChecker = make_checker(robot, self.cell.scene, self.request.what.collision, margin)
        self._prover = EdgeProver(self.checker)
        for name in self.cell.robots:
            make_robot_checker(self.cell, name, margin=margin)  # refuses robots that touch
        self.sessions = {
            name: Session(part, self.cell.scene_of(name), **{k: v for k, v in options.items() if k != "beta"})
            for name, part in self.cell.robots.items()
        }
        self._alone = {name: session.checker for name, session in self.sessions.items()}

    def __repr__(self) -> str:
        return f"<CellPlanner: {self.cell}>"

    def plan(
        self,
        start: object = "start",
        goal: object = "goal",
        *,
        beta: float | None = None,
        timing: TimingRequest | None = TimingRequest(),  # noqa: B008 (frozen)
        progress: Progress = QUIET,
    ) -> Plan:
        """Plan from ``start`` to ``goal``, states of all robots or by robot; return the composite's plan.

        A robot without a goal stays. ``timing`` None returns the path only. Its ``end_notes`` name the attempt that
        succeeded. Raises :class:`StateError` for an unusable start or goal.
        """
        clock, what = Stopwatch(), self.request.what
        beta = self.request.quality.beta if beta is None else beta
        request = self.request.with_options(start=start, goal=goal, beta=beta)
        with clock("setup"):
            how = what.ik_solutions, what.ik_tolerance
            ends = composite_targets(self.cell, request.what.start, request.what.goal, *how, self._alone)
            query = resolve_query(self.checker, *ends, *how).with_texts(request.what.goal)
            limits = None if timing is None else MotionLimits.from_robot(self.checker.robot, timing)
        draft = Plan(request, Outcome.NO_PATH, self.checker, roadmap_of_path(self.checker, query.starts[:1], 0))
        for name, roadmap in self._attempts(query, request, clock, progress):
            draft = Plan(request, Outcome.INTERRUPTED, self.checker, roadmap, end_notes=(*query.end_notes, name))
            if progress.stopped:
                break
            draft = find_path(draft, progress, clock)
            if draft.solved:
                break
        if draft.solved:
            draft = replace(draft, goal=query.goal_at(draft.path[-1]))
            if timing is not None:
                with clock("timing"):
                    draft = replace(draft, trajectory=time_plan(draft, timing, limits))
        elif not progress.stopped:
            with clock("reason"):
                draft = replace(draft, reason=why_no_path(draft, progress))
        return replace(draft, timings=clock.seconds)

    def _attempts(
        self, query: Query, request: PlanRequest, clock: Stopwatch, progress: Progress
    ) -> Iterator[tuple[str, Roadmap]]:
        """Yield names and roadmaps of attempts, the cheapest first; the last one is the tree of all joints."""
        begin, ends = query.starts[0], query.goals
        for end in ends:
            with clock("in turn"):
                path = self._coordinate(self._own_paths(begin, end, request, ()))
            if path is not None:
                yield "in turn: each robot on its own path", self._roadmap(path, request)
        orders = list(itertools.permutations(self.cell.robots))[:_ORDERS]
        if len(self.cell.robots) <= _FEW:
            yield from self._in_orders(begin, ends, orders, request, clock, progress)
        with clock("together"):
            together = load_or_build_roadmap(request.quality, query, progress)
        if together.is_connected:
            yield "together: a tree of all joints", together
        if len(self.cell.robots) > _FEW:
            yield from self._in_orders(begin, ends, orders, request, clock, progress)
        yield "neither in turn nor together", together

    def _in_orders(
        self,
        begin: Floats,
        ends: Floats,
        orders: Sequence[tuple[str, ...]],
        request: PlanRequest,
        clock: Stopwatch,
        progress: Progress,
    ) -> Iterator[tuple[str, Roadmap]]:
        for end, order in itertools.product(ends, orders):
            if progress.stopped:
                return
            with clock("in turn"):
                path = self._coordinate(self._own_paths(begin, end, request, order))
            if path is not None:
                with clock("in turn"):
                    path = MotionChecker(self._prover).shorten_path(path)
                yield f"in turn: {', then '.join(order)}", self._roadmap(path, request)

    def _own_paths(
        self, begin: Floats, end: Floats, request: PlanRequest, order: Sequence[str]
    ) -> dict[str, Floats] | None:
        """Return the path of each robot past the others at rest: those before it in ``order`` at their goals.

        Without an order the others are not there. None if a robot has no path.
        """
        paths = dict[str, Floats]()
        for name, columns in self.cell.columns.items():
            at = {
                other: (end if order.index(other) < order.index(name) else begin)[self.cell.columns[other]]
                for other in (order if order else ())
                if other != name
            }
            session, alone = self.sessions[name], self._alone[name]
            session.world.restore(self._among(alone, at) if at else alone)
            try:
                plan = session.plan(begin[columns], end[columns], beta=request.quality.beta, timing=None)
            except StateError:  # another robot rests where this one starts or ends
                return None
            if not plan.solved:
                return None
            paths[name] = plan.path
        return paths

    def _among(self, alone: CollisionChecker, at: dict[str, Floats]) -> CollisionChecker:
        """Return the checker of one robot among the links of others at rest."""
        world = alone.world
        resting = [item for name, q in at.items() for item in _links_at(self._alone[name], f"{name} ", q)]
        scene = replace(world.scene, obstacles=(*world.scene.obstacles, *resting))
        return type(alone)(world.among(scene, world.robot), alone)

    def _coordinate(self, paths: dict[str, Floats] | None) -> Floats | None:
        if paths is None:
            return None
        velocity = [MotionLimits.from_robot(self.cell.robots[name]).velocity for name in paths]
        return coordinate(list(paths.values()), velocity, self._prover)

    def _roadmap(self, path: Floats, request: PlanRequest) -> Roadmap:
        return roadmap_of_path(self.checker, path, request.quality.seed)


def _links_at(checker: CollisionChecker, prefix: str, q: Floats) -> Iterator[Obstacle]:
    """Yield the moving bodies of a robot at ``q`` (dof,) as obstacles."""
    robot = checker.robot
    rotation, position = joint_placements(Chain.from_arm(robot), q[None])
    for body in robot.bodies:
        if body.joint:
            placement = np.eye(4)
            placement[:3, :3], placement[:3, 3] = rotation[body.joint, 0], position[body.joint, 0]
            yield Obstacle(prefix + body.name, body.shape, placement @ body.placement)


def plan_in_turn(request: PlanRequest, timing: TimingRequest | None, progress: Progress = QUIET) -> Plan:
    """Return the plan of a request for a cell by a new :class:`CellPlanner`.

    Raises :class:`OptionError` for options that it does not have.
    """
    plain, given = PlanRequest(), request.values()
    for name, value in plain.values().items():
        if (
            name not in ("cell", "start", "goal", "ik_solutions", "ik_tolerance", "in_turn", *OPTIONS)
            and given[name] != value
        ):
            raise OptionError(f"--{name.replace('_', '-')} must be left out with --in-turn: plan the robots together.")
    cell_planner = CellPlanner(request.what.cell, **{name: given[name] for name in OPTIONS if given[name] is not None})  # type: ignore[arg-type]
    plan = cell_planner.plan(request.what.start, request.what.goal, timing=timing, progress=progress)
    return replace(plan, request=request)
