"""The path of a plan on its roadmap: the field, a second look and healing; the earliest motion where obstacles move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner import gabf
from planner.base.arrays import frozen
from planner.base.errors import SceneError
from planner.base.progress import Progress, Stopwatch
from planner.planning.result import Plan
from planner.planning.why_no_path import why_no_path
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, TimingRequest
from planner.roadmap.roadmap import path_waypoints, roomy_part
from planner.search.network import build_network, path_cost
from planner.search.search import RoadmapPaths, search, second_looks
from planner.trajectory.earliest import earliest_motion, why_not_in_time
from planner.trajectory.limits import MotionLimits


def solve(draft: Plan, limits: MotionLimits | None, progress: Progress, clock: Stopwatch) -> Plan:
    """The plan with its path; among moving obstacles with the earliest motion within ``limits``, else with a reason."""
    solved = find_path(draft, progress, clock)
    if solved.outcome in (Outcome.NO_PATH, Outcome.TOO_SINGULAR):
        with clock("reason"):
            return replace(solved, reason=why_no_path(solved, progress))
    if solved.solved and solved.scene.moving and limits is not None:
        with clock("timing"):
            return find_earliest(solved, limits, progress)
    return solved


def find_path(draft: Plan, progress: Progress, clock: Stopwatch) -> Plan:
    """The path on the edges that keep the plan's clearance; on all, should second checks leave none of those."""
    request = draft.request
    with clock("costs"):
        network = build_network(draft.roadmap, request.quality.objective, draft.clearance_kept)
    if progress.stopped:
        return draft
    solved = solve_and_heal(draft, network, clock)
    if solved.outcome is Outcome.SOLVED or draft.clearance_kept <= 0:
        return solved
    left = replace(draft, roadmap=solved.roadmap, edges_removed=solved.edges_removed, clearance_kept=0.0)
    return find_path(left, progress, clock)


def solve_and_heal(draft: Plan, network: gabf.Network, clock: Stopwatch, seen: set[bytes] | None = None) -> Plan:
    """The plan with its field and the cheapest path; edges that fail a second look are removed from its roadmap.

    ``seen`` as in :func:`second_looks`.
    """
    request, robot = draft.request, draft.checker.robot
    look, floor = second_looks(draft.checker, draft.roadmap, seen), request.quality.min_manipulability
    with clock("path"):
        paths = RoadmapPaths(draft.roadmap, robot, network, floor, look)
    found = search(paths, gabf.named_law(request.quality.law, request.quality.prescribed_time), clock=clock)
    steps, failed = found.steps, Outcome.TOO_SINGULAR if floor > 0 else Outcome.NO_PATH
    return replace(
        draft,
        outcome=Outcome.SOLVED if len(steps) else failed,
        roadmap=paths.roadmap,
        layered=paths.layered,
        cost_to_go=found.field,
        path=paths.waypoints(steps),
        path_nodes=frozen(paths.layered.roadmap_node[steps], np.int64),
        cost=path_cost(paths.network, steps) if len(steps) else None,
        edges_removed=draft.edges_removed + int((~paths.kept).sum()),
    )


def find_earliest(found: Plan, limits: MotionLimits, progress: Progress) -> Plan:
    """The earliest motion through the plan's roadmap in place of its path, or the reason why there is none."""
    none = replace(found, path=found.path[:0], path_nodes=found.path_nodes[:0], cost=None)
    roomy = roomy_part(found.roadmap, found.clearance_kept)
    earliest = earliest_motion(roomy, found.checker, limits, progress)
    if progress.stopped:
        return replace(none, outcome=Outcome.INTERRUPTED)
    if earliest is None and found.clearance_kept > 0:
        return find_earliest(find_path(replace(found, clearance_kept=0.0), progress, Stopwatch()), limits, progress)
    if earliest is None:
        reason = why_not_in_time(found.roadmap, found.checker, limits, progress)
        return replace(none, outcome=Outcome.NO_PATH, reason=reason)
    assert found.network is not None  # it was solved
    removed = len(roomy.edges) - len(earliest.roadmap.edges)
    return replace(
        found,
        roadmap=earliest.roadmap,
        path=path_waypoints(earliest.roadmap, found.robot, earliest.route.nodes),
        path_nodes=earliest.route.nodes,
        cost=path_cost(found.network, earliest.route.nodes),
        edges_removed=found.edges_removed + removed,
        trajectory=earliest.trajectory,
        route=earliest.route,
    )


def require_earliest(request: PlanRequest, timing: TimingRequest | None) -> None:
    """Refuse options that say how a path is run, or which paths are good, where the earliest motion is asked for."""
    plain = TimingRequest()
    if timing is not None and (timing.time_law, timing.extra_cost) != (plain.time_law, plain.extra_cost):
        raise SceneError(
            "obstacles move in this scene, so the motion runs from rest to rest: leave --time-law and --extra-cost out."
        )
    if request.what.approach > 0 or request.what.retreat > 0:
        raise SceneError(
            "obstacles move in this scene, so no line is kept to at start or goal: leave --approach and --retreat out."
        )
    require_no_floor(request)


def require_no_floor(request: PlanRequest) -> None:
    """Raise :class:`SceneError` for a floor under manipulability where the earliest motion is asked for."""
    if request.quality.min_manipulability > 0:
        raise SceneError(
            "obstacles move in this scene, so the earliest motion is looked for, and no floor under manipulability is "
            "kept: leave --min-manipulability out."
        )
