"""MotionPlanRequest messages: start and goals, and every problem of the sample."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import PlannerError, StateError
from planner.models.files.moveit.requests import LinkGoal, read_motion_plan_request
from planner.problem.request import PlanRequest
from planner.setup.open import make_query
from tests.documents import ROOT
from tests.models.files.moveit.samples import request_text

SAMPLE = ROOT.parent / "shared" / "mbm-panda-sample"
PROBLEMS = sorted(SAMPLE.glob("*/scene*.yaml"))


def test_a_request_gives_start_and_goal(tmp_path: Path) -> None:
    joints = [{"joint_name": f"iiwa14_joint_{k}", "position": 0.1 * k} for k in range(7, 0, -1)]
    (tmp_path / "r.yaml").write_text(request_text(joint_constraints=joints))
    query = make_query(PlanRequest(scene="empty", motion_plan_request=tmp_path / "r.yaml"))
    np.testing.assert_allclose(query.starts, [[0, 0.5, 0, -1.2, 0, 0.8, 0]])
    np.testing.assert_allclose(query.goals, [0.1 * np.arange(1, 8)])
    own = make_query(
        PlanRequest(scene="empty", motion_plan_request=tmp_path / "r.yaml", goal="xyz:0.5,0.1,0.6", ik_solutions=5)
    )
    assert len(own.goals) == 5


def test_a_request_with_a_pose_goal(tmp_path: Path) -> None:
    place = {"constraint_region": {"primitive_poses": [{"position": {"x": 0.5, "y": 0.1, "z": 0.6}}]}}
    turn = {"orientation": {"x": 0, "y": 1, "z": 0, "w": 0}}
    (tmp_path / "r.yaml").write_text(request_text(position_constraints=[place], orientation_constraints=[turn]))
    assert read_motion_plan_request(tmp_path / "r.yaml").goals == (
        LinkGoal("", (0.5, 0.1, 0.6), quaternion=(0.0, 1.0, 0.0, 0.0)),
    )
    assert len(make_query(PlanRequest(scene="empty", motion_plan_request=tmp_path / "r.yaml")).goals) == 8


@pytest.mark.parametrize(
    ("text", "part"),
    [
        (request_text(), "neither joint nor position"),
        (
            "start_state: {}\ngoal_constraints: [{joint_constraints: [{joint_name: a, position: 0}]}]",
            "no joint state to start from",
        ),
        ("goal_constraints: [{}]", "'start_state' is missing"),
        (request_text(joint_constraints=[{"joint_name": "elbow", "position": 1}]), "says nothing of iiwa14_joint_1"),
    ],
)
def test_refused_requests(tmp_path: Path, text: str, part: str) -> None:
    (tmp_path / "r.yaml").write_text(text)
    with pytest.raises(PlannerError) as caught:
        make_query(PlanRequest(scene="empty", motion_plan_request=tmp_path / "r.yaml"))
    assert part in str(caught.value)


def test_goals_are_distinct_and_all_reach_the_target() -> None:
    query = make_query(
        PlanRequest(goal="xyz:0.5,0.3,0.6", scene="empty", start="q:0,0.5,0,-1.2,0,0.8,0", ik_solutions=8)
    )
    from planner.kinematics.forward import tool_positions

    assert len(query.goals) == 8
    np.testing.assert_allclose(tool_positions(query.robot, query.goals), np.tile([0.5, 0.3, 0.6], (8, 1)), atol=1e-5)
    apart = np.abs(query.goals[:, None] - query.goals[None]).max(axis=2) + np.eye(8)
    assert apart.min() > 1e-3


def test_several_named_goals() -> None:
    query = make_query(PlanRequest(goal="home,goal", ik_solutions=2))
    assert len(query.goals) == 3


@pytest.mark.skipif(not PROBLEMS, reason="the sample of MotionBenchMaker problems is not here")
@pytest.mark.parametrize("path", PROBLEMS, ids=lambda path: f"{path.parent.name}-{path.stem[-1]}")
def test_every_sample_problem_is_read(path: Path) -> None:
    request = path.with_name(path.name.replace("scene", "request"))
    asked = PlanRequest(robot="panda", scene=str(path), motion_plan_request=request)
    if (path.parent.name, path.stem[-1]) == ("table_under_pick", "3"):
        with pytest.raises(StateError, match=r"'panda_joint4' at -0\.04.*outside its limits.*by 0\.027 rad"):
            make_query(asked)
        asked = PlanRequest(robot="panda", scene=str(path), motion_plan_request=request, widen_limits=True)
    query = make_query(asked)
    assert query.robot.fixed_joints["panda_finger_joint1"] == 0.065
    assert len(query.scene.obstacles) >= 5
    assert query.goals.shape == (1, 7)
