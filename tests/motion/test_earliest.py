"""The earliest motion among what moves: looked at twice, and a reason where there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import planner.motion.earliest as module
from planner.base.progress import Progress
from planner.base.reasons import BlockedInTime
from planner.collision import make_checker
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact
from planner.kinematics.forward import tool_positions
from planner.motion.earliest import earliest_motion, why_not_in_time
from planner.motion.limits import MotionLimits
from planner.paths.measure import PathContact
from planner.world.moving import KnownMotion, MovingObstacle
from planner.world.poses import pose
from planner.world.shapes import Box, Sphere
from tests.worlds import POST_GOAL, POST_START, load, make_post, post_roadmap

LIMITS = MotionLimits.of(load("planar_2r"))
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
def test_what_is_in_the_way_is_named(moving: list[MovingObstacle], place: str, names: tuple[str, ...]) -> None:
    checker, roadmap = among(*moving), post_roadmap()
    assert earliest_motion(roadmap, checker, LIMITS) is None
    assert why_not_in_time(roadmap, checker, LIMITS) == BlockedInTime(place, names)
    kept = [item for item in moving if item.name not in names]
    assert earliest_motion(roadmap, among(*kept), LIMITS) is not None


def test_for_goals_that_nobody_can_stay_at_nothing_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module.RoadmapInTime, "departures", lambda *_: pytest.fail("an edge was proven in time"))
    assert earliest_motion(post_roadmap(), among(ON_GOAL), LIMITS) is None


def test_an_edge_that_a_second_look_refuses_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    checker, roadmap = among(PASSING), post_roadmap()
    first = earliest_motion(roadmap, checker, LIMITS)
    assert first is not None
    assert first.roadmap is roadmap
    refused = [PathContact(1, 0.0, POST_START, Contact("a", "b")), None]
    monkeypatch.setattr(module, "path_contact", lambda *_: refused.pop(0))
    second = earliest_motion(roadmap, checker, LIMITS)
    assert second is not None
    bad = tuple(first.route.nodes[1:3].tolist())
    assert len(second.roadmap.edges) == len(roadmap.edges) - 1
    with pytest.raises(KeyError):
        second.roadmap.edge_index(*bad)
    assert second.trajectory.duration >= first.trajectory.duration
    assert second.trajectory.proven


def test_a_stop_ends_it() -> None:
    assert earliest_motion(post_roadmap(), among(PASSING), LIMITS, Progress(stop=lambda: True)) is None
