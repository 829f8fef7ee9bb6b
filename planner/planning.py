"""One plan, as the paper's method section: a roadmap, costs, the dynamics, the path. Read this file first."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import OptionError
from planner.base.outcome import Outcome
from planner.base.request import PAPER_NODES, PlanRequest, SweepRequest
from planner.collision import witness
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import recheck
from planner.costs.manipulability_floor import Course, breach, course_of
from planner.costs.network import PathCost, build_network, path_cost
from planner.paths.measure import RECHECK_STEP
from planner.query.open import Query, make_query
from planner.query.resolve import free_configuration
from planner.roadmap.attach import attach
from planner.roadmap.build import RoadmapSettings, grow_roadmap
from planner.roadmap.grow import GrowthSettings
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.storage import load_roadmap, require_same_world
from planner.world.robot import Robot
from planner.world.scene import Scene

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, eq=False)
class Plan:
    """A plan with everything it was made from; ``path`` (k, dof) and ``path_nodes`` are empty where there is none.

    A continuous joint is unwound along the path, so that following it is never a jump. ``course`` is what the dynamics
    ran on, where it came so far: the roadmap, or with a manipulability floor the layers of
    :mod:`planner.costs.manipulability_floor`; ``cost_to_go`` is of its nodes.
    """

    request: PlanRequest
    outcome: Outcome
    robot: Robot
    scene: Scene
    checker: CollisionChecker
    roadmap: Roadmap
    course: Course | None = None
    cost_to_go: gabf.CostToGo | None = None
    path: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    path_nodes: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    cost: PathCost | None = None
    edges_removed: int = 0
    max_error_vs_oracle: float | None = None
    certificate: tuple[gabf.Certificate, ...] = ()
    timings: dict[str, float] = field(default_factory=dict)

    @property
    def network(self) -> gabf.Network | None:
        """The network of ``course``."""
        return None if self.course is None else self.course.network


def plan(
    request: PlanRequest,
    progress: Progress = lambda stage, done, total: None,
    stop: Callable[[], bool] = lambda: False,
) -> Plan:
    """Plan as the paper does: RRT roadmap, manipulability at nodes, GABF for the cost-to-go, minimising neighbours.

    ``progress`` hears (stage, done, total); once ``stop`` returns True the work ends as soon as it can and what there
    is comes back with ``Outcome.INTERRUPTED``. Raises :class:`PlannerError` for unusable input.
    """
    clock = Stopwatch()
    with clock("setup"):
        query = make_query(request)
    with clock("roadmap"):
        roadmap = obtain_roadmap(request, query, progress, stop)
    robot, scene, checker = query.robot, query.scene, query.checker
    draft = Plan(request, Outcome.INTERRUPTED, robot, scene, checker, roadmap, timings=clock.seconds)
    if stop():
        return draft
    with clock("costs"):
        network = build_network(roadmap, request.beta, request.manipulability_cost, request.metric, request.charge)
    return _solve_and_extract(draft, network, clock)


def make_law(request: SweepRequest) -> gabf.Law:
    """The control law by its name; laws without a prescribed time do not mind T_p."""
    match request.law:
        case "nominal":
            return gabf.Nominal()
        case "fixed-time":
            return gabf.FixedTime()
        case "prescribed-time":
            return gabf.PrescribedTime(T=request.prescribed_time)
        case "singularity-free":
            return gabf.SingularityFree(T=request.prescribed_time)


def build_roadmap(
    robot: Robot,
    checker: CollisionChecker,
    start: Floats | Sequence[float],
    goal: Floats | Sequence[float],
    nodes: int = PAPER_NODES,
    seed: int = 0,
    progress: Progress = lambda stage, done, total: None,
    stop: Callable[[], bool] = lambda: False,
    min_manipulability: float = 0.0,
) -> Roadmap:
    """A roadmap of proven edges between configurations ``start`` and ``goal`` ((dof,) or (k, dof), rad).

    With ``min_manipulability`` it grows above that w, but for the ways up to it from a start or goal below.
    Raises :class:`StateError` where one of them is out of limits or in collision.
    """
    if robot is not checker.world.robot:
        raise OptionError("the checker was made for another robot: make one with make_checker(robot, scene).")
    starts, goals = (
        np.array([free_configuration(q, checker, role) for q in np.atleast_2d(np.asarray(rows, dtype=float))])
        for role, rows in (("start", start), ("goal", goal))
    )
    settings = RoadmapSettings(nodes, growth=GrowthSettings(floor=min_manipulability))
    return grow_roadmap(checker, starts, goals, settings, seed, progress, stop)


def path_waypoints(roadmap: Roadmap, robot: Robot, nodes: Ints) -> Floats:
    """The configurations (k, dof) of a node sequence, continuous joints unwound."""
    if not len(nodes):
        return np.zeros((0, robot.dof))
    return frozen(robot.unwound(roadmap.nodes[nodes]))


def obtain_roadmap(request: SweepRequest, query: Query, progress: Progress, stop: Callable[[], bool]) -> Roadmap:
    """The roadmap that ``request`` names, linked to the query's start and goals, or a new one grown around them."""
    checker, starts, goals = query.checker, query.starts, query.goals
    if request.roadmap is None:
        floor = request.min_manipulability
        return build_roadmap(query.robot, checker, starts, goals, request.nodes, request.seed, progress, stop, floor)
    roadmap = load_roadmap(request.roadmap)
    require_same_world(roadmap, checker, request.roadmap)
    return attach(roadmap, checker, starts, goals, request.seed, progress=progress, stop=stop)


def _solve_and_extract(draft: Plan, network: gabf.Network, clock: Stopwatch) -> Plan:
    """Solve, extract, look again; what fails is removed and the field heals from the x at hand.

    An edge fails that touches something when looked at every millimetre, or a leg that dips below the manipulability
    floor. A law that needs an overestimate starts anew: without them costs have risen above the x at hand.
    """
    law, roadmap, floor = make_law(draft.request), draft.roadmap, draft.request.min_manipulability
    course, cost_to_go, removed = course_of(roadmap, network, floor), None, 0
    with clock("path"):
        judge = witness(draft.checker)
    while True:
        with clock("gabf"):
            warm = None if cost_to_go is None or law.needs_overestimate else _warm(cost_to_go.x)
            cost_to_go = gabf.solve(course.network, law=law, x0=warm)
        start = int(course.starts[np.argmin(cost_to_go.x[course.starts])])
        if not np.isfinite(cost_to_go.x[start]):
            outcome = Outcome.TOO_SINGULAR if floor > 0 else Outcome.NO_PATH
            legs = np.zeros(0, dtype=np.int64)
            break
        with clock("path"):
            legs = gabf.extract_path(course.network, cost_to_go, start)
            bad = first_bad_edge(judge, roadmap, course.place[legs])
            low = None if bad else breach(draft.robot, path_waypoints(roadmap, draft.robot, course.place[legs]), floor)
        if bad is not None:
            roadmap, course = roadmap.without_edge(roadmap.edge_index(*bad)), course.without_edge(*bad)
            removed += 1
        elif low is not None:
            course = course.without_leg(int(legs[low]), int(legs[low + 1]))
        else:
            outcome = Outcome.SOLVED
            break
    nodes = course.place[legs]
    return replace(
        draft,
        outcome=outcome,
        roadmap=roadmap,
        course=course,
        cost_to_go=cost_to_go,
        path=path_waypoints(roadmap, draft.robot, nodes),
        path_nodes=frozen(nodes, np.int64),
        cost=path_cost(course.network, legs) if outcome is Outcome.SOLVED else None,
        edges_removed=removed,
        max_error_vs_oracle=gabf.max_error(cost_to_go, gabf.oracle(course.network)),
        certificate=tuple(gabf.certify(course.network, law, cost_to_go)),
    )


def _warm(x: Floats) -> Floats:
    """The x at hand as a start; where a node had no way out any number will do."""
    return np.where(np.isfinite(x), x, np.max(x, where=np.isfinite(x), initial=0.0))


def first_bad_edge(checker: CollisionChecker, roadmap: Roadmap, nodes: Ints) -> tuple[int, int] | None:
    """The first edge of the path that touches something when looked at every millimetre of motion."""
    for i, j in itertools.pairwise(nodes):
        delta = checker.world.robot.difference(roadmap.nodes[i], roadmap.nodes[j])
        if recheck(checker, roadmap.nodes[i], delta, RECHECK_STEP) is not None:
            return int(i), int(j)
    return None


class Stopwatch:
    """Seconds a stage, summed where a stage is entered again."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - begin
