"""``planner robots`` and ``planner scenes``: what they list, and that it fits a terminal."""

from __future__ import annotations

import json

import pytest

from planner.models.scene import Scene
from tests.command_line import Run
from tests.worlds import load


def test_robots_and_scenes_list_what_is_there(run: Run) -> None:
    code, out, _ = run("robots")
    assert code == 0
    for name in ("iiwa14", "panda", "ur5", "ur10", "xarm7", "kinova", "z1", "planar_2r", "panda_joint4", "2.9671"):
        assert name in out
    code, out, _ = run("scenes")
    assert code == 0
    assert "paper" in out


@pytest.mark.parametrize("command", ["robots", "scenes"])
def test_lists_fit_80_columns_and_cut_nothing(run: Run, command: str) -> None:
    code, out, _ = run(command)
    assert code == 0
    assert max(map(len, out.splitlines())) < 80
    assert "…" not in out
    code, text, _ = run(command, "--json")
    assert code == 0
    for record in json.loads(text):
        typed = [record["name"]]
        if command == "robots":
            robot = load(record["name"])
            typed += [robot.tool, *robot.joints]
            assert [joint["name"] for joint in record["joints"]] == list(robot.joints)
            assert record["home"] == robot.home.tolist()
            limits = [[joint["lower"], joint["upper"]] for joint in record["joints"]]
            free = robot.continuous
            assert limits == [
                [None, None] if free[k] else [robot.lower[k], robot.upper[k]] for k in range(len(robot.joints))
            ]
        else:
            scene = Scene.load(record["name"])
            typed += [name for states in scene.states.values() for name in states]
            assert record["states"] == {robot: dict(states) for robot, states in scene.states.items()}
            assert record["obstacles"] == [obstacle.name for obstacle in scene.obstacles]
        words = out.replace(",", " ").replace(":", " ").split()
        assert set(typed) <= set(words)
