"""``benchmarks first-motion``: every method is a row, other environments get the same problem, paths are looked at."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.first_motion.report import OMPL, OURS, WHOLE
from benchmarks.first_motion.run import bench_first_motion, environments
from planner.base.errors import OptionError
from planner.batch.outcomes import REFUSED, SOLVED
from planner.problem.request import LimitsRequest, PlanRequest
from tests.batch.posts import write_problem

PLAIN = PlanRequest(robot="planar_2r", collision="coal", path_only=True)
LIMITS = LimitsRequest(acceleration=15.0, jerk=500.0)


def test_every_method_is_a_row_and_none_is_measured_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, out = tmp_path / "posts", tmp_path / "out"
    write_problem(folder, "0001", (-1.0, 0.8), (1.0, -0.8))
    found = bench_first_motion(folder, out, PLAIN, LIMITS, {"pyroboplan": sys.executable}, seconds=5.0)
    assert [row.method for row in found.rows] == [OURS, WHOLE, OMPL, "pyroboplan"]
    ours, whole, ompl, other = found.rows
    for row in (ours, whole, ompl):
        assert row.outcome == SOLVED, row.message
        assert row.first_s is not None
        assert row.path_s is not None
        assert 0 < row.first_s <= row.path_s
        assert row.length_rad is not None
        assert row.length_rad >= np.hypot(2.0, 1.6) * (1 - 1e-9)
    for row in (ours, whole):
        assert (row.contacts, row.motion_contact, row.proven) == (0, "", True)
    assert "acceleration up to 15 rad/s² (--acceleration 15); jerk up to 500 rad/s³ (--jerk 500)" in ours.limits
    assert ours.ready_s is not None
    assert ours.path_s is not None
    assert ours.motion_s is not None
    assert ours.total_s == pytest.approx(ours.ready_s + ours.path_s + ours.motion_s)
    assert ours.duration_s is not None
    assert ours.duration_s > 0
    assert (ompl.motion_s, ompl.total_s, ompl.duration_s, ompl.largest_share) == (None, None, None, None)
    assert other.outcome == REFUSED
    assert "No module named 'pyroboplan" in other.message
    monkeypatch.setattr("benchmarks.first_motion.run._measure", lambda *_: [])
    again = bench_first_motion(folder, out, PLAIN, LIMITS, {"pyroboplan": sys.executable}, seconds=5.0)
    assert again.rows == found.rows
    assert "(--acceleration 15)" in (out / "first-motion.md").read_text()


@pytest.mark.parametrize("text", ["roboplan", "roboplan=/nowhere/python", f"vamp={sys.executable}"])
def test_environments_are_a_name_and_a_python(text: str) -> None:
    assert environments([f"roboplan={sys.executable}"]) == {"roboplan": sys.executable}
    with pytest.raises(OptionError, match="give NAME=PATH, a planner of roboplan, pyroboplan, hpp and"):
        environments([text])
