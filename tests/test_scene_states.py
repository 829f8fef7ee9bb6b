"""Every built-in robot has a start, a goal and a home in every built-in scene."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.outcome import Outcome
from planner.base.request import PlanRequest, WorldRequest
from planner.base.targets import parse_target
from planner.collision.checker import is_free
from planner.collision.fcl import FclChecker
from planner.planning import plan
from planner.query.open import open_world
from planner.query.resolve import beyond_limits, resolve
from tests.worlds import ROBOTS, SCENES

PAIRS = [(robot, scene) for robot in ROBOTS for scene in SCENES]
# every robot in two scenes, every scene with two robots or three
PLANNED = [pair for pair in PAIRS if (ROBOTS.index(pair[0]) + SCENES.index(pair[1])) % 3 == 0]


@pytest.mark.parametrize(("robot", "scene"), [pair for pair in PAIRS if pair not in PLANNED])
def test_every_robot_can_be_tried_in_every_scene(robot: str, scene: str) -> None:
    """Start, goal and home are within limits and free, or they would be refused."""
    checker = open_world(WorldRequest(robot, scene, collision="coal"))
    states = checker.world.scene.states_of(robot)
    start, goal, _ = (resolve(parse_target(name), checker, states, name, 2) for name in ("start", "goal", "home"))
    assert np.abs(start[0] - goal[0]).max() > 0.1


@pytest.mark.parametrize(("robot", "scene"), PLANNED)
def test_a_robot_gets_from_start_to_goal(robot: str, scene: str) -> None:
    """Start, goal and home are free for both libraries, and joining the two is enough for a path."""
    found = plan(PlanRequest(robot=robot, scene=scene, nodes=2, ik_solutions=2, collision="coal"))
    assert found.outcome is Outcome.SOLVED
    assert found.goal == "goal"
    assert np.abs(found.path[0] - found.path[-1]).max() > 0.1
    home = resolve(parse_target("home"), found.checker, found.scene.states_of(robot), "start")[0]
    fcl = FclChecker(found.checker.world)
    for q in (found.path[0], found.path[-1], home):
        assert is_free(fcl, q)
        assert not beyond_limits(found.robot, q).any()
