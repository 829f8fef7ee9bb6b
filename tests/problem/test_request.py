"""Requests from Python: objects, paths and arrays as well as names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planner
from planner.base.errors import OptionError
from planner.models.scene import Scene
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest
from planner.setup.open import make_query
from tests.worlds import load, make_post


def test_joint_values_become_their_text_to_the_last_bit() -> None:
    q = np.array([0.1 + 0.2, -1.0 / 3.0])
    request = PlanRequest(start=q, goal=list(q))
    assert request.start == request.goal == f"q:{q[0]!r},{q[1]!r}".replace("np.float64(", "").replace(")", "")
    assert isinstance(request.start, str)
    assert [float(v) for v in request.start[2:].split(",")] == q.tolist()


@pytest.mark.parametrize(
    "state", [3.0, [["a"]], np.zeros((2, 2)), None, [], b"abc", {1.0, 2.0}, ["1", "2"], [True, False], np.array([True])]
)
def test_what_is_no_state_is_refused_with_a_sentence(state: object) -> None:
    with pytest.raises(OptionError, match="give one row of joint values"):
        PlanRequest(start=state)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "text", ["", "1e-4", "1e-4,x", "1,1,1", "0,1e-4", "1e-7,1e-4", "1e-4,nan", "0.2,0.1", "0.1,0.6"]
)
def test_a_tolerance_is_metres_and_radians(text: str) -> None:
    with pytest.raises(OptionError, match=r"ik tolerance must be metres and radians .* give them as 1e-6,1e-4"):
        PlanRequest(ik_tolerance=text)
    assert PlanRequest(ik_tolerance="1e-3, 2e-2").tolerance == (1e-3, 2e-2)


def test_a_robot_and_a_scene_themselves_will_do() -> None:
    world = make_post().world
    request = PlanRequest(robot=world.robot, scene=world.scene, start=[-1.0, 0.8], goal=[1.0, -0.8], nodes=40)
    query = make_query(request)
    assert query.robot is world.robot or query.robot.identity == world.robot.identity
    assert query.scene is world.scene
    assert request.to_dict()["robot"] == "planar_2r"
    assert request.to_dict()["scene"] == world.scene.name
    found = planner.plan(request)
    assert found.outcome is Outcome.SOLVED
    assert found.scene is world.scene


def test_paths_are_kept_as_text() -> None:
    request = PlanRequest(robot=Path("arm.urdf"), scene=Path("cell.yaml"), roadmap=Path("r.npz"))
    assert (request.robot, request.scene) == ("arm.urdf", "cell.yaml")
    assert request.to_dict()["roadmap"] == "r.npz"


def test_options_of_plan_are_fields_of_the_request() -> None:
    found = planner.plan(robot=load("planar_2r"), scene=Scene("none"), start=[0.0, 1.0], goal=[1.0, 1.0], nodes=20)
    assert found.request.nodes == 20
    assert repr(found) == f"<Plan: planar_2r in none, solved, {len(found.path)} waypoints>"


def test_a_notebook_shows_each_part_of_a_plan_in_one_line() -> None:
    robot, timing = load("planar_2r"), planner.TimingRequest()
    found = planner.plan(
        robot=robot, scene=Scene("none"), start=[0.0, 1.0], goal=[1.0, 1.0], path_only=True, timing=timing
    )
    assert found.cost_to_go is not None
    assert found.trajectory is not None
    assert repr(robot) == f"<Robot: planar_2r, 2 joints, tool {robot.tool}>"
    assert (repr(found.scene), repr(Scene.load("shelf"))) == ("<Scene: none, empty>", "<Scene: shelf, 8 obstacles>")
    motion, field = repr(found.trajectory), repr(found.cost_to_go)
    assert motion.startswith("<Trajectory: 2 joints, ")
    assert motion.endswith(f" points, {found.trajectory.duration:.3f} s, proven>")
    assert field.startswith(f"<CostToGo: {len(found.cost_to_go.x)} nodes, singularity-free law, settled by tau = ")


def test_paths_may_be_text() -> None:
    request = PlanRequest(roadmap="cell.npz", srdf="arm.srdf")
    assert (request.roadmap, request.srdf) == (Path("cell.npz"), Path("arm.srdf"))
    assert PlanRequest(robot=Path("arm.urdf")).robot == "arm.urdf"
