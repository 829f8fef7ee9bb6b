"""The path of a plan on its roadmap, or the reason why there is none; its motion, the earliest where obstacles move."""

import logging
from dataclasses import asdict, replace

import numpy as np

from planner import gabf
from planner.base.arrays import frozen
from planner.base.errors import SceneError
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.collision.checker import CollisionChecker, with_extra_margin
from planner.collision.recheck import recheck_pieces
from planner.cost.motion_cost import MotionCost
from planner.planning.improvement import prove_path_clearance
from planner.planning.result import Plan
from planner.problem.outcome import FloorTooHigh, NoPath, Outcome
from planner.problem.request import PlanRequest, TimingRequest
from planner.roadmap.build import build_roadmap
from planner.roadmap.infeasibility import explain_separation
from planner.roadmap.roadmap import path_waypoints, with_min_clearance
from planner.search.manipulability_floor import highest_floor
from planner.search.network import build_network, path_cost
from planner.search.search import RoadmapPaths, make_recheck, search
from planner.trajectory.earliest import earliest_motion, explain_blocked_in_time
from planner.trajectory.limits import MotionLimits
from planner.trajectory.timing import time_curve
from planner.trajectory.trajectory import Trajectory

_log = logging.getLogger(__name__)
_NODES = 300  # of a roadmap that grows for a reason only


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
    solved = solve_and_heal(draft, network, clock, progress=progress)
    if solved.outcome is Outcome.SOLVED or draft.clearance_kept <= 0:
        return solved
    left = replace(draft, roadmap=solved.roadmap, edges_removed=solved.edges_removed, clearance_kept=0.0)
    return find_path(left, progress, clock)


def solve_and_heal(draft: Plan, network: gabf.Network, clock: Stopwatch, progress: Progress = QUIET) -> Plan:
    """The plan with its field and the cheapest path; edges that fail a second look are removed from its roadmap."""
    request, robot = draft.request, draft.checker.robot
    look, floor = make_recheck(draft.checker, draft.roadmap, progress=progress), request.quality.min_manipulability
    with clock("path"):
        paths = RoadmapPaths(draft.roadmap, robot, network, floor, look)
    found = search(paths, gabf.law_from_name(request.quality.law, request.quality.prescribed_time), clock=clock)
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
    none = replace(found, path=found.path[:0], path_nodes=found.path_nodes[:0], goal=None, cost=None)
    roomy = with_min_clearance(found.roadmap, found.clearance_kept)
    earliest = earliest_motion(roomy, found.checker, limits, progress)
    if progress.stopped:
        return replace(none, outcome=Outcome.INTERRUPTED)
    if earliest is None and found.clearance_kept > 0:
        return find_earliest(find_path(replace(found, clearance_kept=0.0), progress, Stopwatch()), limits, progress)
    if earliest is None:
        reason = explain_blocked_in_time(found.roadmap, found.checker, limits, progress)
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
    if not roadmap.is_connected:
        apart = explain_separation(roadmap, checker, progress)
        return None if progress.stopped else apart
    if floor <= 0:
        return None  # every path fell below its own ends, or failed the second check
    network = build_network(roadmap, request.quality.objective)
    return FloorTooHigh(floor, highest_floor(failed.robot, roadmap, network, floor))


def time_plan(found: Plan, timing: TimingRequest, limits: MotionLimits | None) -> Trajectory:
    """The motion along a plan's path."""
    quality = found.request.quality
    how = (limits, timing.time_law, quality.min_manipulability, make_timing_cost(found), timing.extra_cost)
    wanted = (
        0.0 if found.scene.limited else quality.extra_clearance
    )  # of obstacles with a speed limit the proof counts the margin
    kept = min(wanted, found.clearance_kept)
    clearance = kept if kept > 0 else prove_path_clearance(found.path, found.checker, wanted)
    made, _ = time_curve(found.path, with_extra_margin(found.checker, clearance), *how)
    if not made.proven and clearance > 0:
        made, _ = time_curve(found.path, found.checker, *how)
    return recheck(made, found.checker)


def recheck(made: Trajectory, checker: CollisionChecker) -> Trajectory:
    """A motion after a second look, which takes the proof from one that is seen to touch."""
    seen = recheck_pieces(checker, made.coefficients)
    if seen is None:
        return made
    t = float(made.times[seen.piece] + seen.s * made.seconds[seen.piece])
    _log.warning("the motion touches at %.3f s (%s), against its proof: it is not to be run", t, seen.contact)
    return replace(made, proven=False, proof=made.proof | {"contact": asdict(seen.contact) | {"t": t}})


def make_timing_cost(found: Plan) -> MotionCost:
    """The objective along motions of any length, charged along them whatever the roadmap charges.

    Motions in time are priced in short chords, on which the ends and the middle are enough.
    """
    objective = replace(found.request.quality.objective, cost_integration="edges", floor=0.0)
    return MotionCost(found.robot, found.roadmap.scale, objective, longest=np.inf, states=3).for_pieces


def require_earliest(request: PlanRequest, timing: TimingRequest | None = None) -> None:
    """Refuse options that say how a path is run, or which paths are good, where the earliest motion is asked for."""
    timing, plain = timing or TimingRequest(), TimingRequest()
    given = {
        "--time-law": timing.time_law != plain.time_law,
        "--extra-cost": timing.extra_cost != plain.extra_cost,
        "--approach": request.what.approach > 0,
        "--retreat": request.what.retreat > 0,
        "--min-manipulability": request.quality.min_manipulability > 0,
    }
    for name in (name for name, is_given in given.items() if is_given):
        raise SceneError(
            f"obstacles move in this scene, and the earliest motion among them takes no {name}: leave it out."
        )
