"""The reason why a plan has no path, as data. Plans that have one do not import this module."""

from __future__ import annotations

from collections.abc import Iterator

from planner import gabf
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.planning.improvement import best_nodes
from planner.planning.result import Plan
from planner.problem.reasons import FloorTooHigh, NoPath
from planner.problem.request import PlanQuality
from planner.roadmap.build import build_roadmap
from planner.roadmap.infeasibility import why_apart
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.robot.robot import Robot
from planner.search.manipulability_floor import first_violation, layered_network, rounded_down
from planner.search.network import build_network

_NODES = 300  # of a roadmap that grows for a reason only
_LOWER = 0.95  # from one floor that is tried to the next
_LEAST = 0.01  # of the first floor: lower ones are not tried


def why_no_path(failed: Plan, progress: Progress = QUIET) -> NoPath | None:
    """A floor that is too high, or the obstacles that keep the parts of the roadmap apart; None where neither is found.

    A roadmap that grew above a floor holds few paths for lower ones: a small one that grows without it is used instead.
    """
    request, checker, roadmap = failed.request, failed.checker, failed.roadmap
    floor = request.quality.min_manipulability
    if floor > 0 and request.quality.roadmap is None:
        ends = roadmap.nodes[roadmap.starts], roadmap.nodes[roadmap.goals]
        roadmap = build_roadmap(
            failed.robot, checker, *ends, min(request.quality.nodes, _NODES), request.quality.seed, progress
        )
    if progress.stopped:
        return None
    if not roadmap.connected:
        apart = why_apart(roadmap, checker, progress)
        return None if progress.stopped else apart
    if floor <= 0:
        return None  # every path fell below its own ends, or failed the second check
    return FloorTooHigh(floor, highest_floor(roadmap, checker, request.quality))


def highest_floor(roadmap: Roadmap, checker: CollisionChecker, quality: PlanQuality) -> float:
    """A floor below the request's that the best path of ``roadmap`` above it keeps to; 0 where none is found.

    Floors are tried from above, as a lower floor may forbid a path that a higher one allows: one that never reaches the
    higher one. Floors above all w on the roadmap allow the same paths: the highest w is tried first.
    """
    network = build_network(roadmap, quality.objective)
    floors = _floors(min(quality.min_manipulability, roadmap.edge_manipulability.max(initial=0.0)))
    return next((floor for floor in floors if _keeps_to(floor, roadmap, network, checker.robot)), 0.0)


def _keeps_to(floor: float, roadmap: Roadmap, network: gabf.Network, robot: Robot) -> bool:
    """Whether the best path of ``roadmap`` above ``floor`` exists and stays above it where it is sampled."""
    path = path_waypoints(roadmap, robot, best_nodes(layered_network(roadmap, network, floor)))
    return len(path) > 0 and first_violation(robot, path, floor) is None


def _floors(below: float) -> Iterator[float]:
    """Numbers of two digits below one, each about ``_LOWER`` of the one before."""
    floor = below
    while floor > _LEAST * below:
        floor = rounded_down(_LOWER * floor)
        yield floor
