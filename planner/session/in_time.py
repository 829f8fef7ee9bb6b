"""A session's plan in time: the earliest motion over the roadmap among obstacles that move, proven and looked at."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.reasons import NoPath
from planner.roadmap.infeasibility import why_apart
from planner.roadmap.roadmap import path_waypoints
from planner.search.network import path_cost
from planner.session.live_world import LiveWorld
from planner.trajectory.earliest import earliest_motion, why_not_in_time
from planner.trajectory.limits import MotionLimits


def planned_in_time(live: LiveWorld, alone: Plan, limits: MotionLimits) -> tuple[LiveWorld, Plan]:
    """The world after all its edges were decided, and the earliest motion; ``alone`` is the plan without what moves."""
    begin = time.perf_counter()
    live = live.proven(np.flatnonzero(live.proofs.open))
    roadmap = live.held(live.proofs.free)
    if not alone.solved:
        return live, _none(replace(alone, roadmap=roadmap), why_apart(roadmap, live.checker), begin)
    found = earliest_motion(roadmap, live.checker, limits)
    if found is None:
        return live, _none(replace(alone, roadmap=roadmap), why_not_in_time(roadmap, live.checker, limits), begin)
    assert alone.network is not None  # it was solved
    return live, replace(
        alone,
        roadmap=roadmap,
        path=path_waypoints(roadmap, live.checker.robot, found.route.nodes),
        path_nodes=found.route.nodes,
        cost=path_cost(alone.network, found.route.nodes),
        trajectory=found.trajectory,
        route=found.route,
        timings=_timings(alone, begin),
    )


def _none(alone: Plan, reason: NoPath | None, begin: float) -> Plan:
    empty = {"path": alone.path[:0], "path_nodes": alone.path_nodes[:0], "goal": None, "cost": None}
    return replace(alone, outcome=Outcome.NO_PATH, reason=reason, timings=_timings(alone, begin), **empty)


def _timings(alone: Plan, begin: float) -> dict[str, float]:
    return alone.timings | {"timing": time.perf_counter() - begin}
