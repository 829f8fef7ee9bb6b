"""Solve a plan on its roadmap: path or reason, motion, and the earliest motion among moving obstacles."""

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
_NODES = 300  # of a roadmap grown only to explain a failure


def solve(draft: Plan, limits: MotionLimits | None, progress: Progress, clock: Stopwatch) -> Plan:
    """Return the plan with its path, or a reason; among moving obstacles with the earliest motion."""
    solved = find_path(draft, progress, clock)
    if solved.outcome in (Outcome.NO_PATH, Outcome.TOO_SINGULAR):
        with clock("reason"):
            return replace(solved, reason=why_no_path(solved, progress))
    if solved.solved and solved.scene.moving and limits is not None:
        with clock("timing"):
            return find_earliest(solved, limits, progress)
    return solved


def find_path(draft: Plan, progress: Progress, clock: Stopwatch) -> Plan:
    """Find the path on edges that keep the plan's clearance, or else on all edges."""
    request = draft.request
    with clock("costs"):
        network = build_network(draft.roadmap, request.quality.objective, draft.clearance_kept)
    if progress.stopped:
        return draft
    solved = solve_and_heal(draft, network, clock, progress=progress)
    if solved.outcome is Outcome.SOLVED or draft.clearance_kept <= 0:
        return solved
    remaining = replace(draft, roadmap=solved.roadmap, edges_removed=solved.edges_removed, clearance_kept=0.0)
    return find_path(remaining, progress, clock)


def solve_and_heal(draft: Plan, network: gabf.Network, clock: Stopwatch, progress: Progress = QUIET) -> Plan:
    """Return the plan with field and cheapest path; edges that fail a recheck are removed."""
    request, robot = draft.request, draft.checker.robot
    look, floor = make_recheck(draft.checker, draft.roadmap, progress=progress), request.quality.min_manipulability
    with clock("path"):
        paths = RoadmapPaths(draft.roadmap, robot, network, floor, look)
    result = search(paths, gabf.law_from_name(request.quality.law, request.quality.prescribed_time), clock=clock)
    steps, failed = result.steps, Outcome.TOO_SINGULAR if floor > 0 else Outcome.NO_PATH
    return replace(
        draft,
        outcome=Outcome.SOLVED if len(steps) else failed,
        roadmap=paths.roadmap,
        layered=paths.layered,
        cost_to_go=result.field,
        path=paths.waypoints(steps),
        path_nodes=frozen(paths.layered.roadmap_node[steps], np.int64),
        cost=path_cost(paths.network, steps) if len(steps) else None,
        edges_removed=draft.edges_removed + int((~paths.kept).sum()),
    )


def find_earliest(plan: Plan, limits: MotionLimits, progress: Progress) -> Plan:
    """Return the plan with the earliest motion through its roadmap, or the reason why there is none."""
    none = replace(plan, path=plan.path[:0], path_nodes=plan.path_nodes[:0], goal=None, cost=None)
    roomy = with_min_clearance(plan.roadmap, plan.clearance_kept)
    earliest = earliest_motion(roomy, plan.checker, limits, progress)
    if progress.stopped:
        return replace(none, outcome=Outcome.INTERRUPTED)
    if earliest is None and plan.clearance_kept > 0:
        return find_earliest(find_path(replace(plan, clearance_kept=0.0), progress, Stopwatch()), limits, progress)
    if earliest is None:
        reason = explain_blocked_in_time(plan.roadmap, plan.checker, limits, progress)
        return replace(none, outcome=Outcome.NO_PATH, reason=reason)
    assert plan.network is not None  # it was solved
    removed = len(roomy.edges) - len(earliest.roadmap.edges)
    return replace(
        plan,
        roadmap=earliest.roadmap,
        path=path_waypoints(earliest.roadmap, plan.robot, earliest.route.nodes),
        path_nodes=earliest.route.nodes,
        cost=path_cost(plan.network, earliest.route.nodes),
        edges_removed=plan.edges_removed + removed,
        trajectory=earliest.trajectory,
        route=earliest.route,
    )


def why_no_path(failed: Plan, progress: Progress = QUIET) -> NoPath | None:
    """Return why there is no path: floor too high, or obstacles between components; None if unknown.

    A roadmap grown above a floor has few paths below it, so a small roadmap is grown without the floor.
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
        return None  # every path dips below its ends, or fails a recheck
    network = build_network(roadmap, request.quality.objective)
    return FloorTooHigh(floor, highest_floor(failed.robot, roadmap, network, floor))


def time_plan(plan: Plan, timing: TimingRequest, limits: MotionLimits | None) -> Trajectory:
    """Return the motion along a plan's path."""
    quality = plan.request.quality
    how = (limits, timing.time_law, quality.min_manipulability, make_timing_cost(plan), timing.extra_cost)
    # proofs against obstacles with a speed limit use the margin only
    requested = 0.0 if plan.scene.limited else quality.extra_clearance
    kept = min(requested, plan.clearance_kept)
    clearance = kept if kept > 0 else prove_path_clearance(plan.path, plan.checker, requested)
    motion, _ = time_curve(plan.path, with_extra_margin(plan.checker, clearance), *how)
    if not motion.proven and clearance > 0:
        motion, _ = time_curve(plan.path, plan.checker, *how)
    return recheck(motion, plan.checker)


def recheck(motion: Trajectory, checker: CollisionChecker) -> Trajectory:
    """Sample a motion with a second checker; return it, without its proof if a contact is found."""
    contact = recheck_pieces(checker, motion.coefficients)
    if contact is None:
        return motion
    t = float(motion.times[contact.piece] + contact.s * motion.seconds[contact.piece])
    _log.warning("the motion touches at %.3f s (%s), against its proof: do not run it", t, contact.contact)
    return replace(motion, proven=False, proof=motion.proof | {"contact": asdict(contact.contact) | {"t": t}})


def make_timing_cost(plan: Plan) -> MotionCost:
    """Return the objective as an integral along motions, also if the roadmap integrates over nodes.

    Motions are priced in short chords, for which both ends and the middle suffice.
    """
    objective = replace(plan.request.quality.objective, cost_integration="edges", floor=0.0)
    return MotionCost(plan.robot, plan.roadmap.scale, objective, longest=np.inf, states=3).for_pieces


def require_earliest(request: PlanRequest, timing: TimingRequest | None = None) -> None:
    """Raise :class:`SceneError` for options that an earliest motion cannot respect."""
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
            f"{name} must be left out where obstacles move, as the plan is the earliest motion: remove it."
        )
