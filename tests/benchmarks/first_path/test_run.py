"""``benchmarks first-path``: every method is a row, other environments get the same problem, paths are looked at."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.first_path.report import OMPL, OURS
from benchmarks.first_path.run import bench_first_path, environments
from planner.base.errors import OptionError
from planner.batch.outcomes import REFUSED, SOLVED
from planner.problem.request import PlanRequest
from tests.batch.posts import write_problem

PLAIN = PlanRequest(robot="planar_2r", collision="coal", path_only=True)


def test_every_method_is_a_row_and_none_is_measured_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, out = tmp_path / "posts", tmp_path / "out"
    write_problem(folder, "0001", (-1.0, 0.8), (1.0, -0.8))
    found = bench_first_path(folder, out, PLAIN, {"pyroboplan": sys.executable}, seconds=5.0)
    assert [row.method for row in found.rows] == [OURS, OMPL, "pyroboplan"]
    ours, ompl, other = found.rows
    for row in (ours, ompl):
        assert row.outcome == SOLVED, row.message
        assert row.first_s is not None
        assert row.path_s is not None
        assert 0 < row.first_s <= row.path_s
        assert row.length_rad is not None
        assert row.length_rad >= np.hypot(2.0, 1.6) * (1 - 1e-9)
    assert ours.contacts == 0
    assert other.outcome == REFUSED
    assert "No module named 'pyroboplan" in other.message
    monkeypatch.setattr("benchmarks.first_path.run._measure", lambda *_: [])
    again = bench_first_path(folder, out, PLAIN, {"pyroboplan": sys.executable}, seconds=5.0)
    assert again.rows == found.rows


@pytest.mark.parametrize("text", ["roboplan", "roboplan=/nowhere/python", f"vamp={sys.executable}"])
def test_environments_are_a_name_and_a_python(text: str) -> None:
    assert environments([f"roboplan={sys.executable}"]) == {"roboplan": sys.executable}
    with pytest.raises(OptionError, match="give NAME=PATH, a planner of roboplan, pyroboplan"):
        environments([text])
