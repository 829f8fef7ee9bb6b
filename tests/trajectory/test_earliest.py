"""The earliest motion among what moves: looked at twice, and a reason where there is none."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.kinematics.forward import tool_positions
from planner.problem.outcome import BlockedInTime
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.shapes import Box, Sphere
from planner.trajectory.earliest import earliest_motion, explain_blocked_in_time
from planner.trajectory.limits import MotionLimits
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap

LIMITS = MotionLimits.from_robot(load("planar_2r"))
FAR = pose([3.0, 3.0, 0.0])


def among(*moving: MovingObstacle) -> CollisionChecker:
    return make_checker(load("planar_2r"), replace(make_post().world.scene, moving=moving))


def ball(name: str, *places: np.ndarray, radius: float = 0.08) -> MovingObstacle:
    return MovingObstacle(name, Sphere(radius), KnownMotion([5.0 * k for k in range(len(places))], places))


def at_tool(q: np.ndarray) -> np.ndarray:
    return pose(tool_positions(load("planar_2r"), q[None])[0].tolist())


PASSING = ball("passing", FAR, pose([3.0, -3.0, 0.0]))
ON_START, ON_GOAL = ball("first", at_tool(POST_START), FAR), ball("last", FAR, at_tool(POST_GOAL))
# both stand across everything between start and goal
WALLS = tuple(
    MovingObstacle(name, Box((1.2, 0.02, 0.4)), KnownMotion([0.0], [pose(rpy=[0, 0, turn]) @ pose([0.7, 0, 0])]))
    for name, turn in (("wall", 0.0), ("other", -0.05))
)


@pytest.mark.parametrize(
    ("moving", "place", "names"),
    [
        ([PASSING, ON_START], "start", ("first",)),
        ([ON_GOAL, PASSING], "goal", ("last",)),
        ([PASSING, WALLS[0]], "route", ("wall",)),
        ([*WALLS], "route", ("wall", "other")),
    ],
    ids=["start", "goal", "one on the route", "two on the route"],
)
def test_what_is_in_the_way_is_named(moving: list[MovingObstacle], place: Any, names: tuple[str, ...]) -> None:
    checker, roadmap = among(*moving), post_roadmap()
    assert earliest_motion(roadmap, checker, LIMITS) is None
    assert explain_blocked_in_time(roadmap, checker, LIMITS) == BlockedInTime(place, names)
    kept = [item for item in moving if item.name not in names]
    assert earliest_motion(roadmap, among(*kept), LIMITS) is not None


@pytest.mark.parametrize("seed", range(6))
def test_without_those_that_are_named_there_is_a_motion_and_none_of_them_can_be_put_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    spots = rng.uniform([-0.4, -0.9], [1.0, 0.9], (10, 2))
    still = [ball(f"{k}", pose([*spot, 0.0]), radius=0.12) for k, spot in enumerate(spots)]
    checker, roadmap = among(*still), post_roadmap()
    assert earliest_motion(roadmap, checker, LIMITS) is None
    reason = explain_blocked_in_time(roadmap, checker, LIMITS)
    for name in (None, *reason.obstacles):
        kept = [item for item in still if item.name not in reason.obstacles or item.name == name]
        why = None
        if earliest_motion(roadmap, among(*kept), LIMITS) is None:
            why = explain_blocked_in_time(roadmap, among(*kept), LIMITS)
        if name is None:
            assert why is None or why.place != reason.place
        else:
            assert why is not None
            assert why.place == reason.place


def test_what_stands_on_the_goal_and_vanishes_is_waited_for() -> None:
    gone = 6.001
    for where in ([3.0, 3.0, 0.0], [0.0, 0.0, -9999.0]):
        there = at_tool(POST_GOAL)
        vanishing = MovingObstacle("gone", Box((0.1, 0.1, 0.1)), KnownMotion([0, 6, gone], [there, there, pose(where)]))
        found = earliest_motion(post_roadmap(), among(vanishing), LIMITS)
        assert found is not None
        assert found.trajectory.proven
        assert 6.0 < found.route.arrivals[-1] < 7.0
