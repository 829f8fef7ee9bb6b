"""One plan, as the paper's method section: a roadmap, costs, the dynamics, the path. Read this file first.

What grows and improves roadmaps, OMPL with it, is imported where it is used: a plan on a kept roadmap needs none of it,
and would wait for it longer than it takes itself.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from planner import gabf
from planner.base.arrays import frozen
from planner.base.errors import SceneError
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.planning.legs import legs_of
from planner.planning.result import Plan
from planner.problem.objective import Objective
from planner.problem.outcome import Outcome
from planner.problem.reasons import CannotFollow
from planner.problem.request import PlanRequest, TimingRequest, with_objective
from planner.query.query import make_query
from planner.roadmap.obtain import obtain_roadmap
from planner.roadmap.roadmap import path_waypoints, roomy_part
from planner.search.network import build_network, path_cost
from planner.search.search import RoadmapPaths, search, second_looks
from planner.tool_paths.ladder_roadmap import roadmap_of
from planner.trajectory.limits import MotionLimits

_EXTREMES, _ROUNDS_PER_EXTREME = (0.0, 1.0), 1  # betas refined too, else the one asked for would be best for all


def plan(
    request: PlanRequest | None = None,
    progress: Progress = QUIET,
    timing: TimingRequest | None = None,
    objective: Objective | None = None,
    **options: Any,
) -> Plan:
    """Plan as the paper does: RRT roadmap, manipulability at nodes, GABF for the cost-to-go, minimising neighbours.

        plan(robot="panda", scene="shelf", beta=0.2)
        plan(PlanRequest.from_options(seed=3), nodes=200)
        plan(robot="ur5", objective=Objective(beta=0.2, metric="workspace"))

    ``options`` are those of :class:`PlanRequest`, in place of those of ``request``, as is what an ``objective`` says.
    With ``timing`` a path that is
    found becomes a trajectory too, see :func:`planner.trajectory.timing.time_path`. ``progress`` is called with
    (stage, done, total); once it is asked to stop the work ends as soon as it can, and what there is comes back with
    ``Outcome.INTERRUPTED``. Raises :class:`PlannerError` for unusable input, :class:`KeywordError` for other options.

    Where obstacles move along known motions the plan is the earliest motion through the roadmap that keeps clear of
    them, waiting included, and ``beta`` shapes the roadmap only; this needs ``timing``.
    """
    request, clock = (request or PlanRequest()).with_options(**options), Stopwatch()
    if objective is not None:
        request = with_objective(request, objective, options)
    with clock("setup"):
        query = make_query(request.what, in_time=timing is not None)
        limits = None if timing is None else MotionLimits.of(query.robot, timing)
        if query.scene.moving:
            _require_earliest(request, timing)
        legs = legs_of(query, request)
    begun = {"checker": query.checker, "timings": clock.seconds, "end_notes": query.end_notes}
    if isinstance(legs, CannotFollow):
        nowhere = roadmap_of(query.checker, np.concatenate([query.starts, query.goals]), request.quality.seed)
        return Plan(request, Outcome.NO_PATH, roadmap=nowhere, reason=legs, **begun)
    with clock("roadmap"):
        roadmap = obtain_roadmap(request.quality, legs.between(query), progress)
    draft = Plan(request, Outcome.INTERRUPTED, roadmap=roadmap, **begun)
    if progress.stopped:
        return draft
    with clock("improve"):
        better = legs.attached(improved(draft, progress))
    if progress.stopped:
        return draft
    solved = _solved(better, progress, clock)
    if solved.outcome is Outcome.INTERRUPTED:
        return draft
    if solved.outcome is not Outcome.SOLVED:
        from planner.planning.why_no_path import why_no_path

        with clock("reason"):
            return replace(solved, reason=why_no_path(solved, progress))
    if query.scene.moving and limits is not None:
        with clock("timing"):
            solved = _in_time(solved, limits, progress)
        if solved.outcome is not Outcome.SOLVED:
            return solved
    solved = replace(solved, goal=query.goal_at(solved.path[-1]), legs=legs.records(query.robot, solved.path))
    if timing is None or solved.trajectory is not None:
        return solved
    with clock("timing"):
        return legs.timed(solved, timing, limits)


def _solved(improved: Plan, progress: Progress, clock: Stopwatch) -> Plan:
    """The path on the edges that keep the plan's clearance; on all, should second checks leave none of those."""
    request = improved.request
    with clock("costs"):
        network = build_network(improved.roadmap, request.quality.objective, improved.clearance_kept)
    if progress.stopped:
        return improved
    solved = solve_and_heal(improved, network, clock)
    if solved.outcome is Outcome.SOLVED or improved.clearance_kept <= 0:
        return solved
    left = replace(improved, roadmap=solved.roadmap, edges_removed=solved.edges_removed, clearance_kept=0.0)
    return _solved(left, progress, clock)


def _require_earliest(request: PlanRequest, timing: TimingRequest | None) -> None:
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


def _in_time(found: Plan, limits: MotionLimits, progress: Progress) -> Plan:
    """The earliest motion through the plan's roadmap in place of its path, or the reason why there is none."""
    from planner.trajectory.earliest import earliest_motion, why_not_in_time

    none = replace(found, path=found.path[:0], path_nodes=found.path_nodes[:0], cost=None)
    roomy = roomy_part(found.roadmap, found.clearance_kept)
    earliest = earliest_motion(roomy, found.checker, limits, progress)
    if progress.stopped:
        return replace(none, outcome=Outcome.INTERRUPTED)
    if earliest is None and found.clearance_kept > 0:
        return _in_time(_solved(replace(found, clearance_kept=0.0), progress, Stopwatch()), limits, progress)
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


def improved(draft: Plan, progress: Progress) -> Plan:
    """The plan on a roadmap whose best path is refined; a new one keeps the number of nodes that was asked for."""
    quality = draft.request.quality
    if quality.roadmap is not None and quality.rounds < 1:
        return draft  # on the roadmap as it is kept
    from planner.planning.improvement import improved_roadmap, of_size_asked, roomy_roadmap, with_path_above_ends

    roadmap, room = roomy_roadmap(draft.roadmap, draft.checker, quality, progress)
    improved = improved_roadmap(roadmap, draft.checker, quality, quality.beta, progress, room)
    roadmap = improved.roadmap
    for beta in _EXTREMES:
        if beta != quality.beta and quality.rounds > 0:
            fewer = replace(quality, effort=min(quality.rounds, _ROUNDS_PER_EXTREME))
            roadmap = improved_roadmap(roadmap, draft.checker, fewer, beta, progress, room).roadmap
    if quality.beta == 0.0 and quality.min_manipulability <= 0:
        roadmap = with_path_above_ends(roadmap, draft.checker, quality, progress, room)
    if quality.roadmap is None:
        roadmap = of_size_asked(roadmap, len(draft.roadmap.nodes), quality, room)
    return replace(draft, roadmap=roadmap, curve=improved.curve, clearance_kept=room)


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
