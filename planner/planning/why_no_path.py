"""The reason why a plan has no path, as data. Plans that have one do not import this module."""

from __future__ import annotations

from planner.base.progress import QUIET, Progress
from planner.planning.result import Plan
from planner.problem.outcome import FloorTooHigh, NoPath
from planner.roadmap.build import build_roadmap
from planner.roadmap.infeasibility import why_apart
from planner.search.manipulability_floor import highest_floor
from planner.search.network import build_network

_NODES = 300  # of a roadmap that grows for a reason only


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
    network = build_network(roadmap, request.quality.objective)
    return FloorTooHigh(floor, highest_floor(failed.robot, roadmap, network, floor))
