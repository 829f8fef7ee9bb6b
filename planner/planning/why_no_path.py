"""Why a plan has no path, as data; it grows roadmaps, so plans that have one do not load it."""

from __future__ import annotations

from planner.base.progress import QUIET, Progress
from planner.construction.build import build_roadmap
from planner.construction.infeasibility import why_apart
from planner.planning.highest_floor import highest_floor, highest_grown_floor
from planner.planning.result import Plan
from planner.problem.reasons import FloorTooHigh, NoPath

_NODES = 300  # of a roadmap that grows for a reason only


def why_no_path(failed: Plan, progress: Progress = QUIET) -> NoPath | None:
    """Why a plan has no path: a floor that is too high, or what keeps the parts of the roadmap from each other.

    A roadmap that grew above a floor says little of lower ones: a small one that grew without it does.
    """
    request, checker, roadmap = failed.request, failed.checker, failed.roadmap
    floor = request.min_manipulability
    grew_above = floor > 0 and request.roadmap is None
    if grew_above:
        ends = roadmap.nodes[roadmap.starts], roadmap.nodes[roadmap.goals]
        nodes = min(request.nodes, _NODES)
        roadmap = build_roadmap(failed.robot, checker, *ends, nodes, request.seed, progress)
    if progress.stopped:
        return None
    if not roadmap.connected:
        apart = why_apart(roadmap, checker, progress)
        return None if progress.stopped else apart
    if floor <= 0:
        return None  # every path fell below its own ends, or failed the second check
    if grew_above:
        return FloorTooHigh(floor, highest_grown_floor(roadmap, checker, request, progress))
    return FloorTooHigh(floor, highest_floor(roadmap, checker, request))
