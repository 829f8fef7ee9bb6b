"""The text of a robot file: it loads as the same robot, and its comments say why pairs are off."""

from __future__ import annotations

from pathlib import Path

from planner.base.resources import robots_folder
from planner.collision.coal import CoalChecker
from planner.collision.self_pairs import generate_disabled_pairs
from planner.query.robot_yaml import robot_yaml
from planner.robot.files.robot_files import read_robot
from planner.robot.robot import Robot

ARM = str(robots_folder() / "examples" / "arm.urdf")


def test_it_loads_as_the_same_robot_with_its_pairs(tmp_path: Path) -> None:
    files, robot = read_robot(ARM, None), Robot.load(ARM, tool="tip")
    pairs = generate_disabled_pairs(robot, CoalChecker)
    text = robot_yaml(files, robot, pairs, tmp_path)
    (tmp_path / "robot.yaml").write_text(text)
    again = Robot.load(str(tmp_path / "robot.yaml"))
    assert (again.joints, again.tool, again.home.tolist()) == (robot.joints, robot.tool, robot.home.tolist())
    assert again.disabled_pairs == pairs
    assert "# joined by one joint" in text
