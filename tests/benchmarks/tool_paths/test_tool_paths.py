"""The benchmark of tool paths: its judge sees what is off, and its rows say what was followed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.tool_paths import run
from benchmarks.tool_paths.judge import deviations
from benchmarks.tool_paths.report import aims
from benchmarks.tool_paths.run import bench_tool_paths
from planner.base.errors import OptionError
from planner.planning.follow import Follower
from planner.problem.request import FollowRequest
from planner.setup.open import open_world
from planner.tool_paths.file import read_tool_path
from tests.tool_paths.judge import line_of


def test_the_judge_sees_how_far_off_the_tool_is() -> None:
    path = line_of([[0, 0, 0], [1, 0, 0], [1, 1, 0]], axis=[0, 0, 1])
    lean = np.array([[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]])
    off, angle = deviations(path, np.array([np.eye(3), lean]), np.array([[0.5, 0.0, 0.01], [1.02, 0.5, 0.0]]))
    assert off == pytest.approx([0.01, 0.02])
    assert angle == pytest.approx([0.0, 0.2], abs=1e-12)


def test_another_planner_is_told_where_the_path_is_from_the_arms_base(monkeypatch: pytest.MonkeyPatch) -> None:
    """The scene puts the arm on a table; its URDF, which is all that the other one reads, does not."""
    told: list[dict] = []

    def answer(_name: str, _python: str, _file: str, problem: dict, _wait: float) -> dict:
        told.append(problem)
        return {"message": "path fraction 0.25"}

    monkeypatch.setattr(run, "answer_of", answer)
    request = FollowRequest(robot="ur5", scene="table")
    checker = open_world(request)
    base = checker.robot.base
    assert base[2, 3] > 0.5
    path = read_tool_path({"points": [{"position": [0.4, y, 1.2], "axis": [0, 0, -1]} for y in (-0.05, 0.05)]})
    found = run._by_roboplan("python", Follower.of(path, request).plan(request), checker, path)
    assert found == {"roboplan_followed": 0.25}
    np.testing.assert_allclose((base @ np.array(told[0]["poses"]))[:, :3, 3], path.positions, atol=1e-12)


def test_rows_say_what_was_followed_and_are_kept(tmp_path: Path) -> None:
    found = bench_tool_paths(tmp_path, ("ur5",), ("empty",), ("line",), 1)
    (row,) = found.rows
    assert row.followed > 0
    assert row.proven
    assert max(row.position, row.angle) <= 1.0
    assert row.contacts == 0
    assert all(aim.holds for aim in aims([row])[1:4])
    assert "| ur5 | empty | line |" in found.report
    assert bench_tool_paths(tmp_path, ("ur5",), ("empty",), ("line",), 1).rows == (row,)
    with pytest.raises(OptionError, match="kind 'spiral' not found"):
        bench_tool_paths(tmp_path, kinds=("spiral",))
