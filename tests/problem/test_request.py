"""Requests from Python: objects, paths and arrays as well as names."""

import planner
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.query.query import make_query
from tests.worlds import make_post


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
