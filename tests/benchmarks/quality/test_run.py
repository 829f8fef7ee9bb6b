"""``benchmarks quality``: every method is a row, ratios are to RRTConnect's, and rows that are there are kept."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.quality.run import bench_quality
from planner.base.errors import OptionError
from planner.batch.outcomes import SOLVED
from planner.problem.request import PlanRequest
from tests.batch.posts import write_problem

PLAIN = PlanRequest(robot="planar_2r", nodes=40, collision="coal")


def test_every_method_is_a_row_and_none_is_measured_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_problem(tmp_path / "posts", "0001", (-1.0, 0.8), (1.0, -0.8))
    folder, out = tmp_path / "posts", tmp_path / "out"
    found = bench_quality(folder, out, PLAIN, betas=(1.0,), efforts=(2,), seconds=0.3)
    assert found.complete
    assert [one.method for one in found.rows] == ["RRTConnect", "RRT*", "BIT*", "planner"]
    assert {one.outcome for one in found.rows} == {SOLVED}
    assert all(one.length_rad is not None and one.length_rad >= (one.straight_rad or 0.0) for one in found.rows)
    ours = found.rows[-1]
    assert ours.cost is not None
    assert ours.lower_bound is not None
    assert ours.lower_bound <= ours.cost
    monkeypatch.setattr("benchmarks.quality.run._measure", lambda *_: [])
    again = bench_quality(folder, out, PLAIN, betas=(1.0,), efforts=(2,), seconds=0.3)
    assert again.rows == found.rows
    with pytest.raises(OptionError, match="at least one beta"):
        bench_quality(folder, out, PLAIN, betas=())
