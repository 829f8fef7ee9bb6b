"""The SO-101 as a built-in robot: names as LeRobot's motors have them, and goals that five joints can meet."""

import json
from pathlib import Path

import numpy as np
import pytest

from planner.kinematics.forward import tool_pose
from planner.robot.robot import Robot
from tests.command_line import Run

DOWN = np.array([0.0, 0.0, -1.0])


@pytest.mark.parametrize(("tilt", "goal"), [(0.0, "axis:z,0,0,-1"), (0.2, "axis:z,0,0,-1,0.2")])
def test_a_position_and_one_axis_are_met(tilt: float, goal: str, run: Run, tmp_path: Path) -> None:
    position = "0.2,0.09,0.06"
    words = ("--robot", "so101", "--scene", "empty", "--start", "home", "--goal", f"xyz:{position} & {goal}")
    code, _, err = run("plan", *words, "--nodes", "40", "--refinement-rounds", "0", "--no-page", "--out", str(tmp_path))
    assert code == 0, err
    plan = json.loads((tmp_path / "plan.json").read_text())
    robot = Robot.load("so101")
    pose = tool_pose(robot, np.array(plan["path"][-1])).homogeneous
    np.testing.assert_allclose(pose[:3, 3], [float(value) for value in position.split(",")], atol=2e-3)
    assert pose[:3, 2] @ DOWN >= np.cos(tilt + 1e-3)
    assert json.loads((tmp_path / "trajectory.json").read_text())["proven"]


def test_joint_values_are_met(run: Run, tmp_path: Path) -> None:
    q = [1.0, -0.5, 0.5, 0.4, 1.5]
    goal = "q:" + ",".join(map(str, q))
    words = ("--robot", "so101", "--scene", "empty", "--start", "home", "--goal", goal, "--path-only")
    assert run("plan", *words, "--out", str(tmp_path))[0] == 0
    path = json.loads((tmp_path / "plan.json").read_text())["path"]
    assert path[-1] == q


def test_a_whole_pose_is_refused_in_a_sentence(run: Run, tmp_path: Path) -> None:
    words = ("--robot", "so101", "--scene", "empty", "--start", "home", "--goal", "pose:0.22,0.12,0.1,0,0,0,1")
    code, _, err = run("plan", *words, "--path-only", "--out", str(tmp_path / "out"))
    assert code == 3
    assert "goal" in err
    assert not (tmp_path / "out").exists()


def test_joints_have_the_names_of_lerobots_motors() -> None:
    robot = Robot.load("so101")
    assert robot.joints == ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")
    assert set(robot.fixed_joints) == {"gripper"}
