"""Requests from Python: objects, paths and arrays as well as names."""

from pathlib import Path

import numpy as np
import pytest

import planner
from planner.base.errors import OptionError
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.query.query import make_query
from tests.worlds import make_post


@pytest.mark.parametrize("state", [3.0, np.zeros((2, 2)), None, [], {1.0, 2.0}, ["1", "2"], [True, False]])
def test_what_is_no_state_is_refused_with_a_sentence(state: object) -> None:
    with pytest.raises(OptionError, match="must be one row of joint values"):
        PlanRequest.from_options(start=state)


@pytest.mark.parametrize("text", ["1e-4", "1e-4,x", "0,1e-4", "1e-4,nan", "0.1,0.6"])
def test_a_tolerance_is_metres_and_radians(text: str) -> None:
    with pytest.raises(OptionError, match=r"ik tolerance must be metres and radians .* give them as 1e-6,1e-4"):
        PlanRequest.from_options(ik_tolerance=text)
    assert PlanRequest.from_options(ik_tolerance="1e-3, 2e-2").what.ik_tolerance == (1e-3, 2e-2)


def test_a_robot_and_a_scene_themselves_will_do() -> None:
    world = make_post().world
    request = PlanRequest.from_options(
        robot=world.robot, scene=world.scene, start=[-1.0, 0.8], goal=[1.0, -0.8], nodes=40
    )
    query = make_query(request.what)
    assert query.robot is world.robot or query.robot.identity == world.robot.identity
    assert query.scene is world.scene
    assert request.config()["robot"] == "planar_2r"
    assert request.config()["scene"] == world.scene.name
    found = planner.plan(request=request, timing=None)
    assert found.outcome is Outcome.SOLVED
    assert found.scene is world.scene


def test_paths_are_kept_as_text() -> None:
    request = PlanRequest.from_options(robot=Path("arm.urdf"), scene=Path("cell.yaml"), roadmap=Path("r.npz"))
    assert (request.what.robot, request.what.scene) == ("arm.urdf", "cell.yaml")
    assert request.config()["roadmap"] == "r.npz"
