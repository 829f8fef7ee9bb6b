"""A query's answer in time: the earliest motion over the roadmap among obstacles that move, proven and looked at."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.construction.infeasibility import why_apart
from planner.problem.outcome import Outcome
from planner.problem.reasons import NoPath
from planner.roadmap.roadmap import path_waypoints
from planner.session.live_world import LiveWorld
from planner.session.report import Answer
from planner.trajectory.earliest import earliest_motion, why_not_in_time
from planner.trajectory.limits import MotionLimits
from planner.trajectory.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class TimedAnswer:
    """The answer of :meth:`planner.Session.plan_in_time`; empty arrays and no trajectory where there is none.

    ``path`` (k, dof) rad and ``path_nodes`` (k,) are the waypoints, ``arrivals`` and ``departures`` (k,) s when each is
    reached and left: what lies between is a wait. ``trajectory.proof`` holds what is proven.
    """

    outcome: Outcome
    trajectory: Trajectory | None
    path: Floats
    path_nodes: Ints
    arrivals: Floats
    departures: Floats
    seconds: float
    reason: NoPath | None = None  # why there is none

    @property
    def solved(self) -> bool:
        return self.outcome is Outcome.SOLVED

    @property
    def waits(self) -> Floats:
        """(k,) seconds stood at each waypoint on the way."""
        return self.departures - self.arrivals


def timed_answer(live: LiveWorld, answer: Answer, limits: MotionLimits) -> tuple[LiveWorld, TimedAnswer]:
    """The world after all its edges were decided, and the earliest motion; ``answer`` is that without what moves."""
    begin = time.perf_counter()
    if not answer.solved:
        live = live.proven(np.flatnonzero(live.proofs.open))
        reason = why_apart(live.held(live.proofs.free), live.checker)
        return live, _none(live, reason, begin)
    live = live.proven(np.flatnonzero(live.proofs.open))
    roadmap = live.held(live.proofs.free)
    found = earliest_motion(roadmap, live.checker, limits)
    if found is None:
        return live, _none(live, why_not_in_time(roadmap, live.checker, limits), begin)
    path = path_waypoints(roadmap, live.checker.robot, found.route.nodes)
    return live, TimedAnswer(
        Outcome.SOLVED,
        found.trajectory,
        path,
        found.route.nodes,
        found.route.arrivals,
        found.route.departures,
        answer.seconds + time.perf_counter() - begin,
    )


def _none(live: LiveWorld, reason: NoPath, begin: float) -> TimedAnswer:
    empty, path = np.zeros(0), np.zeros((0, live.checker.robot.dof))
    seconds = time.perf_counter() - begin
    return TimedAnswer(Outcome.NO_PATH, None, path, np.zeros(0, dtype=np.int64), empty, empty, seconds, reason)
