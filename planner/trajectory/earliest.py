"""The earliest motion over a roadmap among moving obstacles, or the obstacles that block it."""

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
    """A route in time and its trajectory, whose ``proof`` holds the proofs.

    ``roadmap`` lacks the edges on which a second library found a contact.
    """

    trajectory: Trajectory
    route: TimedRoute
    roadmap: Roadmap


def earliest_motion(
    roadmap: Roadmap, checker: CollisionChecker, limits: MotionLimits, progress: Progress = QUIET
) -> TimedMotion | None:
    """Return the earliest motion from a start to a goal among the scene's moving obstacles, or None.

    See :func:`planner.trajectory.safe_intervals.earliest_route`. coal rechecks the route at every millimetre of motion
    of robot or obstacles; the search continues without an edge that fails. None also after a request to stop.
    """
    prover = TimedProver(checker, checker.world.scene.moving)
    while True:
        timed = RoadmapInTime(roadmap, prover, limits)
        route = earliest_route(timed, _find_usable_starts(roadmap, prover), roadmap.goals, progress)
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
    """Return the moving obstacles that block the start, the goal, or the route, in this order.

    Without the named ones the motion exists; with any one of them added it does not. ``roadmap`` connects a start to a
    goal. A request to stop ``progress`` may lengthen the list.
    """
    moving = checker.world.scene.moving

    def roadmap_among(obstacles: Sequence[MovingObstacle]) -> RoadmapInTime:
        return RoadmapInTime(roadmap, TimedProver(checker, obstacles), limits)

    def has_route(obstacles: Sequence[MovingObstacle]) -> bool:
        timed = roadmap_among(obstacles)
        return earliest_route(timed, _find_usable_starts(roadmap, timed.prover), roadmap.goals, progress) is not None

    for end in ("start", "goal"):
        if not _can_rest(roadmap_among(moving), end):
            return BlockedInTime(end, _find_blockers(moving, lambda some, end=end: _can_rest(roadmap_among(some), end)))
    return BlockedInTime("route", _find_blockers(moving, has_route))


def _find_blockers(
    moving: Sequence[MovingObstacle], works: Callable[[Sequence[MovingObstacle]], bool]
) -> tuple[str, ...]:
    """Return obstacles without which ``works`` is true, none of which can be added; all if it never is.

    It adds obstacles one by one, as :mod:`planner.roadmap.infeasibility` does with static ones.
    """
    harmless: list[MovingObstacle] = []
    for item in moving:
        if works([*harmless, item]):
            harmless.append(item)
    blockers = tuple(item.name for item in moving if item not in harmless)
    return blockers if works(harmless) else tuple(item.name for item in moving)


def _find_usable_starts(roadmap: Roadmap, prover: TimedProver) -> Ints:
    """Return the starts outside every closed mesh at time 0."""
    return frozen([node for node in roadmap.starts if prover.starts(roadmap.nodes[node])], np.int64)


def _can_rest(timed: RoadmapInTime, end: str) -> bool:
    """Return whether the robot can rest at some start from time 0 on, or at some goal for good."""
    roadmap = timed.roadmap
    if end == "start":
        intervals = [timed.rest_intervals(int(node), 0.0) for node in _find_usable_starts(roadmap, timed.prover)]
        return any(len(rows) and rows[0, 0] == 0.0 for rows in intervals)
    return any(np.isfinite(timed.safe_from(node)) for node in roadmap.goals.tolist())


def _find_touching_edge(
    roadmap: Roadmap, checker: CollisionChecker, route: TimedRoute, trajectory: Trajectory
) -> tuple[int, int] | None:
    """Return the edge on which coal finds a contact with a static or a moving obstacle, or None."""
    nodes = route.nodes.tolist()
    if len(nodes) == 1:
        return None
    path: Floats = path_waypoints(roadmap, checker.robot, route.nodes)
    contact = path_contact(second_checker(checker), path)
    if contact is not None:
        return nodes[contact.piece], nodes[contact.piece + 1]
    touch = first_touch_in_time(trajectory, checker, checker.world.scene.moving, RECHECK)
    if touch is None:
        return None
    k = min(int(np.searchsorted(route.departures, touch[0], side="right")), len(nodes) - 1)
    return nodes[k - 1], nodes[k]
