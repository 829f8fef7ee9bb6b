"""The text of a robot file: it loads as the same robot, and its comments say why pairs are off."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from planner.base.resources import robots_folder
from planner.collision.coal import CoalChecker
from planner.collision.pair_survey import Reason, survey_pairs
from planner.models.files.robot_files import read_robot
from planner.models.robot import Robot
from planner.setup.robot_yaml import robot_yaml

ARM = str(robots_folder() / "examples" / "arm.urdf")


@pytest.mark.parametrize("trust", [False, True])
def test_it_loads_as_the_same_robot_with_its_pairs(trust: bool, tmp_path: Path) -> None:
    files, robot = read_robot(ARM, None), Robot.load(ARM, tool="tip")
    survey = survey_pairs(robot, CoalChecker, samples=50, seed=0)
    text = robot_yaml(files, robot, survey, tmp_path, trust)
    (tmp_path / "robot.yaml").write_text(text)
    again = Robot.load(str(tmp_path / "robot.yaml"))
    assert (again.joints, again.tool, again.home.tolist()) == (robot.joints, robot.tool, robot.home.tolist())
    off = [Reason.ADJACENT, Reason.ALWAYS, Reason.APART, *([Reason.NEVER] if trust else [])]
    expected = {frozenset(pair) for reason in off for pair in survey.pairs(reason)}
    assert again.disabled_pairs == expected
    assert {frozenset(pair) for pair in yaml.safe_load(text)["disabled_pairs"] or []} == expected
    for reason in off:
        assert (f"# {reason.value}" in text) == bool(survey.pairs(reason))
