"""The highest manipulability floor that some path is found to keep to."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from planner import gabf
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.construction.build import build_roadmap
from planner.construction.obtain import obtain_roadmap
from planner.models.robot import Robot
from planner.planning.improvement import best_nodes
from planner.planning.manipulability_floor import first_violation, layered_network, rounded_down
from planner.planning.network import build_network
from planner.problem.request import PlanRequest
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.sampling.growth_settings import GrowthSettings
from planner.setup.open import Query

_LOWER = 0.95  # from one floor that is tried to the next
_LOWER_GROWN = 0.7  # the same, where each one takes a roadmap of its own
_LEAST = 0.01  # of the first floor: lower ones are not tried
_NODES = 300  # of such a roadmap, at most
_QUICK = GrowthSettings(join_motions=10_000)


def highest_floor(roadmap: Roadmap, checker: CollisionChecker, request: PlanRequest) -> float:
    """A floor below the request's that the best path of ``roadmap`` above it keeps to; 0 where none is found.

    Tried from above, as a lower floor may forbid what a higher one allows: a path that never reaches the higher one.
    Floors above all w on the roadmap allow the same paths: the highest w is the first that is tried lower.
    """
    network = build_network(roadmap, request.objective)
    floors = _floors(min(request.min_manipulability, roadmap.edge_manipulability.max(initial=0.0)), _LOWER)
    return next((floor for floor in floors if _keeps_to(floor, roadmap, network, checker.robot)), 0.0)


def highest_grown_floor(
    free: Roadmap, checker: CollisionChecker, request: PlanRequest, progress: Progress = QUIET
) -> float:
    """As :func:`highest_floor`, of roadmaps that grow above the floors; ``free`` is one that grew without.

    The roadmap that ``request`` asks for keeps to it too, not only a smaller one.
    """
    starts, goals = free.nodes[free.starts], free.nodes[free.goals]
    bound, nodes = highest_floor(free, checker, request), min(request.nodes, _NODES)
    query = Query(checker.robot, checker.world.scene, checker, starts, goals, ("goal",) * len(goals))

    def quickly(floor: float) -> Roadmap:
        return build_roadmap(checker.robot, checker, starts, goals, nodes, request.seed, progress, floor, growth=_QUICK)

    def as_asked(floor: float) -> Roadmap:
        return obtain_roadmap(replace(request, min_manipulability=floor), query, progress, request.path_only)

    for floor in (bound, *_floors(bound, _LOWER_GROWN)):
        if floor <= 0 or progress.stopped:
            break
        grown = (grow(floor) for grow in (quickly, as_asked))  # one after the other
        if all(_keeps_to(floor, each, build_network(each, request.objective), checker.robot) for each in grown):
            return floor
    return 0.0


def _keeps_to(floor: float, roadmap: Roadmap, network: gabf.Network, robot: Robot) -> bool:
    """Whether the best path of ``roadmap`` above ``floor``, if there is one, is seen to stay above it."""
    path = path_waypoints(roadmap, robot, best_nodes(layered_network(roadmap, network, floor)))
    return len(path) > 0 and first_violation(robot, path, floor) is None


def _floors(below: float, factor: float) -> Iterator[float]:
    """Numbers of two digits below one, each about ``factor`` of the one before."""
    floor = below
    while floor > _LEAST * below:
        floor = rounded_down(factor * floor)
        yield floor
