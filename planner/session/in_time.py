"""A query's answer in time: the earliest motion over the roadmap among obstacles that move, proven and looked at."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.base.outcome import Outcome
from planner.base.resolutions import RECHECK
from planner.collision.edge_prover import EdgeProver
from planner.collision.in_time import TimedProver
from planner.motion.in_time import first_touch_in_time
from planner.motion.limits import MotionLimits
from planner.motion.proof import prove_motion
from planner.motion.safe_intervals import RoadmapInTime, TimedRoute, earliest_route
from planner.motion.trajectory import Trajectory
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.session.live_world import LiveWorld
from planner.session.report import Answer


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
        return live, _none(live, answer.outcome, begin)
    live = live.proven(np.flatnonzero(live.proofs.open))
    roadmap, prover = live.held(live.proofs.free), TimedProver(live.checker, live.scene.moving)
    while True:
        starts = [node for node in roadmap.starts if prover.starts(roadmap.nodes[node])]
        timed = RoadmapInTime(roadmap, prover, limits)
        route = earliest_route(timed, frozen(starts, np.int64), roadmap.goals)
        if route is None:
            return live, _none(live, Outcome.NO_PATH, begin)
        trajectory, bad = _judged(live, roadmap, route, prover, limits)
        if bad is None:
            path = path_waypoints(roadmap, live.checker.robot, route.nodes)
            times = route.arrivals, route.departures
            found = TimedAnswer(
                Outcome.SOLVED, trajectory, path, route.nodes, *times, answer.seconds + time.perf_counter() - begin
            )
            return live, found
        roadmap = roadmap.without_edge(roadmap.edge_index(*bad))


def _judged(
    live: LiveWorld, roadmap: Roadmap, route: TimedRoute, prover: TimedProver, limits: MotionLimits
) -> tuple[Trajectory, tuple[int, int] | None]:
    """The route's trajectory with its proof, and the edge on which coal sees a contact that no proof did."""
    trajectory = route.trajectory(roadmap, prover, limits)
    proof = prove_motion(trajectory, EdgeProver(live.checker), limits)
    world = live.world
    record = proof.to_dict(world.margin, live.checker.name)
    trajectory = replace(trajectory, limits=limits, proven=proof.whole, proof=record)
    seen = first_touch_in_time(trajectory, live.checker, live.scene.moving, RECHECK)
    if seen is None or len(route.nodes) == 1:
        return trajectory, None
    k = min(int(np.searchsorted(route.departures, seen[0], side="right")), len(route.nodes) - 1)
    return trajectory, (int(route.nodes[k - 1]), int(route.nodes[k]))


def _none(live: LiveWorld, outcome: Outcome, begin: float) -> TimedAnswer:
    empty = np.zeros(0)
    path = np.zeros((0, live.checker.robot.dof))
    return TimedAnswer(outcome, None, path, np.zeros(0, dtype=np.int64), empty, empty, time.perf_counter() - begin)
