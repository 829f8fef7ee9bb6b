"""``planner robot-yaml``, and the options that choose the planned joints."""

import json
from pathlib import Path

import pytest

from planner.base.resources import robots_folder
from planner.robot.robot import Robot
from tests.command_line import Run

ARM = str(robots_folder() / "examples" / "arm.urdf")


@pytest.fixture
def made(run: Run, tmp_path: Path) -> Path:
    """A robot file for the example arm."""
    out = tmp_path / "mine" / "robot.yaml"
    code, text, error = run("robot-yaml", ARM, "--tool", "tip", "--out", str(out))
    assert code == 0, error
    assert "pairs of links that need no check" in text
    assert "home is free, 8 of 8 tool positions are reached" in text
    return out


def test_the_file_loads_is_the_same_again_and_is_not_overwritten(run: Run, made: Path, tmp_path: Path) -> None:
    own, plain = Robot.load(str(made)), Robot.load(ARM, tool="tip")
    assert (own.name, own.joints, own.tool) == (plain.name, plain.joints, "tip")
    assert own.disabled_pairs
    again = tmp_path / "mine" / "again.yaml"
    assert run("robot-yaml", ARM, "--tool", "tip", "--out", str(again))[0] == 0
    assert again.read_text() == made.read_text()
    copy = tmp_path / "mine" / "copy.yaml"
    assert run("robot-yaml", str(made), "--out", str(copy))[0] == 0
    assert Robot.load(str(copy)).identity == own.identity
    code, _, error = run("robot-yaml", ARM, "--tool", "tip", "--out", str(made))
    assert (code, "exists and is not overwritten" in error) == (3, True)


def test_a_plan_with_some_joints_and_its_roadmap(run: Run, made: Path, tmp_path: Path) -> None:
    joints = ",".join(Robot.load(str(made)).joints[:2])
    options = ("--robot", str(made), "--scene", "empty", "--joints", joints)
    out, kept = str(tmp_path / "out"), str(tmp_path / "out" / "roadmap.npz")
    plan = ("plan", *options, "--start", "home", "--goal", "q:0.3,0.4", "--nodes", "30", "--out", out)
    code, _, error = run(*plan)
    assert code == 0, error
    record = json.loads((tmp_path / "out" / "plan.json").read_text())
    assert record["joints"] == joints.split(",")
    assert record["config"]["joints"] == joints
    code, _, error = run("plan", *options[:4], "--start", "home", "--goal", "home", "--roadmap", kept, "--out", out)
    assert (code, "build one for this robot" in error) == (3, True)
    assert run("check", str(tmp_path / "out" / "plan.json"), *options)[0] == 0
    assert run("view", *options, "--state", "home", "--out", str(tmp_path / "state.html"))[0] == 0
