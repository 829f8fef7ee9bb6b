"""Every built-in robot has a start, a goal and a home in every built-in scene; published problems can be planned."""

import itertools

import numpy as np
import pytest

from planner.collision.checker import is_free
from planner.collision.fcl import FclChecker
from planner.kinematics.forward import tool_pose
from planner.planning.plan import plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, WorldRequest
from planner.problem.targets import parse_target
from planner.query.query import make_checker_for
from planner.query.resolve import beyond_limits, resolve
from planner.robot.poses import pose
from tests.worlds import ROBOTS, SCENES

PAIRS = [(robot, scene) for robot in ROBOTS for scene in SCENES]
# every robot in one scene or two, every scene with one robot or two
PLANNED = [pair for pair in PAIRS if (ROBOTS.index(pair[0]) + SCENES.index(pair[1])) % 5 == 0]


@pytest.mark.parametrize(("robot", "scene"), [pair for pair in PAIRS if pair not in PLANNED])
def test_every_robot_can_be_tried_in_every_scene(robot: str, scene: str) -> None:
    """Start, goal and home are within limits and free, or they would be refused."""
    checker = make_checker_for(WorldRequest(robot, scene, collision="coal"))
    states = checker.world.scene.states_of(robot)
    start, goal, _ = (resolve(parse_target(name), checker, states, name, 2) for name in ("start", "goal", "home"))
    assert np.abs(start[0] - goal[0]).max() > 0.1


@pytest.mark.parametrize(("robot", "scene"), PLANNED)
def test_a_robot_gets_from_start_to_goal(robot: str, scene: str) -> None:
    """Start, goal and home are free for both libraries, and joining the two is enough for a path."""
    found = plan(
        request=PlanRequest.from_options(robot=robot, scene=scene, nodes=2, ik_solutions=2, collision="coal"),
        timing=None,
    )
    assert found.outcome is Outcome.SOLVED
    assert found.goal == "goal"
    assert np.abs(found.path[0] - found.path[-1]).max() > 0.1
    home = resolve(parse_target("home"), found.checker, found.scene.states_of(robot), "start")[0]
    fcl = FclChecker(found.checker.world)
    for q in (found.path[0], found.path[-1], home):
        assert is_free(fcl, q)
        assert not beyond_limits(found.robot, q).any()


TASKS = ("above-shelf", "top-shelf", "centre-shelf", "left-bin", "right-bin", "above-shelf")
GRIPPER = {  # position (m) and rpy (rad) of the gripper's body, as the paper's code has them
    "above-shelf": ((0.75, -0.12, 0.9), (0, -np.pi, -np.pi / 2)),
    "top-shelf": ((0.75, 0.12, 0.67), (0, -np.pi, -np.pi / 2)),
    "centre-shelf": ((0.75, 0.12, 0.41), (0, -np.pi, -np.pi / 2)),
    "left-bin": ((0.08, 0.6, 0.22), (np.pi / 2, np.pi, 0)),
    "right-bin": ((-0.08, -0.6, 0.22), (np.pi / 2, np.pi, np.pi)),
}


@pytest.mark.parametrize(("start", "goal"), list(itertools.pairwise(TASKS)))
def test_every_task_of_the_gcs_paper_has_a_proven_path(start: str, goal: str) -> None:
    """From where the paper puts the gripper, on the flange and turned by 90 degrees, with the gripper carried along."""
    found = plan(
        request=PlanRequest.from_options(
            robot="iiwa14", scene="gcs", start=start, goal=goal, collision="coal", path_only=True
        ),
        timing=None,
    )
    assert found.outcome is Outcome.SOLVED
    fcl = FclChecker(found.checker.world)
    for name, q in ((start, found.path[0]), (goal, found.path[-1])):
        flange = tool_pose(found.robot, q).homogeneous
        position, rpy = GRIPPER[name]
        np.testing.assert_allclose(flange @ pose((0, 0, 0.069), (np.pi / 2, 0, 0)), pose(position, rpy), atol=2e-6)
        assert is_free(fcl, q)
