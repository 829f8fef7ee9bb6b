"""The earliest motion over a roadmap among obstacles that move, proven and looked at; or what is in its way."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import RECHECK
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.collision.timed_prover import TimedProver
from planner.problem.outcome import BlockedInTime
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.robot.moving import MovingObstacle
from planner.trajectory.limits import MotionLimits
from planner.trajectory.measure import path_contact
from planner.trajectory.moving_obstacles import first_touch_in_time
from planner.trajectory.proof import prove_motion
from planner.trajectory.safe_intervals import RoadmapInTime, TimedRoute, earliest_route
from planner.trajectory.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class TimedMotion:
    """A route in time and its trajectory, whose ``proof`` holds what is proven.

    ``roadmap`` lacks the edges on which a second look found a contact that no proof did.
    """

    trajectory: Trajectory
    route: TimedRoute
    roadmap: Roadmap


def earliest_motion(
    roadmap: Roadmap, checker: CollisionChecker, limits: MotionLimits, progress: Progress = QUIET
) -> TimedMotion | None:
    """The earliest motion from a start to a goal among the obstacles that move in the checker's scene.

    See :func:`planner.trajectory.safe_intervals.earliest_route`. What it uses is looked at once more by coal, at every
    millimetre that robot or obstacles move: an edge that fails is left out, and the search goes on. None where there is
    no motion, or it is asked to stop.
    """
    prover = TimedProver(checker, checker.world.scene.moving)
    while True:
        timed = RoadmapInTime(roadmap, prover, limits)
        route = earliest_route(timed, _usable_starts(roadmap, prover), roadmap.goals, progress)
        if route is None:
            return None
        trajectory = route.trajectory(roadmap, prover, limits)
        bad = _find_touching_edge(roadmap, checker, route, trajectory)
        if bad is None:
            proof = prove_motion(trajectory, EdgeProver(checker), limits)
            record = proof.to_dict(checker.world.margin, checker.name)
            return TimedMotion(replace(trajectory, limits=limits, proven=proof.whole, proof=record), route, roadmap)
        roadmap = roadmap.without_edge(roadmap.edge_index(*bad))


def explain_blocked_in_time(
    roadmap: Roadmap, checker: CollisionChecker, limits: MotionLimits, progress: Progress = QUIET
) -> BlockedInTime:
    """Which moving obstacles keep the arm at the start, from the goal, or on the way, as far as that is found.

    Without those that are named it could; with any one of them put back it could not. ``roadmap`` joins a start and a
    goal. Where ``progress`` is asked to stop, more may be named.
    """
    moving = checker.world.scene.moving

    def timed(among: Sequence[MovingObstacle]) -> RoadmapInTime:
        return RoadmapInTime(roadmap, TimedProver(checker, among), limits)

    def passes(among: Sequence[MovingObstacle]) -> bool:
        there = timed(among)
        starts = _usable_starts(roadmap, there.prover)
        return earliest_route(there, starts, roadmap.goals, progress) is not None

    for place in ("start", "goal"):
        if not _can_stand(timed(moving), place):
            return BlockedInTime(
                place, _find_blockers(moving, lambda among, place=place: _can_stand(timed(among), place))
            )
    return BlockedInTime("route", _find_blockers(moving, passes))


def _find_blockers(
    moving: Sequence[MovingObstacle], works: Callable[[Sequence[MovingObstacle]], bool]
) -> tuple[str, ...]:
    """The names of some without which it ``works``, none of which can be put back; all where it never does.

    They are put back one after the other, as :mod:`planner.roadmap.infeasibility` does with obstacles that stand.
    """
    kept: list[MovingObstacle] = []
    for item in moving:
        if works([*kept, item]):
            kept.append(item)
    left = tuple(item.name for item in moving if item not in kept)
    return left if works(kept) else tuple(item.name for item in moving)


def _usable_starts(roadmap: Roadmap, prover: TimedProver) -> Ints:
    """The starts that lie in no closed mesh at time 0."""
    return frozen([node for node in roadmap.starts if prover.starts(roadmap.nodes[node])], np.int64)


def _can_stand(timed: RoadmapInTime, place: str) -> bool:
    """Whether some start can be stood at from time 0 on, or some goal for good."""
    roadmap = timed.roadmap
    if place == "start":
        stays = [timed.stays(int(node), 0.0) for node in _usable_starts(roadmap, timed.prover)]
        return any(len(spans) and spans[0, 0] == 0.0 for spans in stays)
    return any(np.isfinite(timed.stays_for_good_from(node)) for node in roadmap.goals.tolist())


def _find_touching_edge(
    roadmap: Roadmap, checker: CollisionChecker, route: TimedRoute, trajectory: Trajectory
) -> tuple[int, int] | None:
    """The edge on which coal sees a contact, with what stands or with what moves; None where it sees none."""
    nodes = route.nodes.tolist()
    if len(nodes) == 1:
        return None
    path: Floats = path_waypoints(roadmap, checker.robot, route.nodes)
    contact = path_contact(second_checker(checker), path)
    if contact is not None:
        return nodes[contact.piece], nodes[contact.piece + 1]
    seen = first_touch_in_time(trajectory, checker, checker.world.scene.moving, RECHECK)
    if seen is None:
        return None
    k = min(int(np.searchsorted(route.departures, seen[0], side="right")), len(nodes) - 1)
    return nodes[k - 1], nodes[k]
