"""Every built-in robot has a start, a goal and a home in every built-in scene."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.outcome import Outcome
from planner.base.request import PlanRequest
from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.planning import plan
from planner.query.open import make_query
from planner.query.resolve import beyond_limits
from tests.worlds import ROBOTS, SCENES


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("robot", ROBOTS)
def test_every_robot_can_be_tried_in_every_scene(robot: str, scene: str) -> None:
    """Start, goal and home are free for both libraries, and joining the two is enough for a path."""
    found = plan(PlanRequest(robot=robot, scene=scene, nodes=2, ik_solutions=2, collision="coal"))
    assert found.outcome is Outcome.SOLVED
    assert found.goal == "goal"
    assert np.abs(found.path[0] - found.path[-1]).max() > 0.1
    fcl = make_checker(found.robot, found.scene, backend="fcl")
    home = make_query(PlanRequest(robot=robot, scene=scene, start="home", ik_solutions=2, collision="coal")).starts[0]
    for q in (found.path[0], found.path[-1], home):
        assert is_free(fcl, q)
        assert not beyond_limits(found.robot, q).any()
