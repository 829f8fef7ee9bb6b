"""The benchmark of tool paths: its judge sees what is off, and its rows say what was followed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.tool_paths.judge import deviations
from benchmarks.tool_paths.report import aims
from benchmarks.tool_paths.run import bench_tool_paths
from planner.base.errors import OptionError
from tests.tool_paths.judge import line_of


def test_the_judge_sees_how_far_off_the_tool_is() -> None:
    path = line_of([[0, 0, 0], [1, 0, 0], [1, 1, 0]], axis=[0, 0, 1])
    lean = np.array([[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]])
    off, angle = deviations(path, np.array([np.eye(3), lean]), np.array([[0.5, 0.0, 0.01], [1.02, 0.5, 0.0]]))
    assert off == pytest.approx([0.01, 0.02])
    assert angle == pytest.approx([0.0, 0.2], abs=1e-12)


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
