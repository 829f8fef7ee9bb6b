"""``benchmarks motion``: one problem, planned, timed and judged; a second run measures nothing."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks.motion.run import bench_motion
from planner.base.errors import PlannerError
from planner.problem.request import LimitsRequest, PlanRequest
from tests.documents import ROOT

EXAMPLES = ROOT / "scenes" / "examples"
PLAIN = PlanRequest("panda", collision="coal", nodes=60)


def problems(folder: Path) -> Path:
    folder.mkdir()
    for kind in ("scene", "request"):
        shutil.copy(EXAMPLES / f"{kind}0001.yaml", folder)
    return folder


def test_a_problem_is_timed_judged_and_kept(tmp_path: Path) -> None:
    folder, limits = problems(tmp_path / "one"), LimitsRequest(acceleration=5.0)
    result = bench_motion(folder, tmp_path / "out", PLAIN, limits)
    (row,) = result.rows
    assert result.complete
    assert (row.outcome, row.contact, row.proven) == ("solved", "", True)
    assert row.largest_share is not None
    assert row.largest_share <= 1.0
    assert row.timed_s is not None
    assert row.stopping_s is not None
    assert row.timed_s <= row.stopping_s
    assert "| all | 1 | 1 | 1 | 0 |" in result.report
    again = bench_motion(folder, tmp_path / "out", PLAIN, limits)
    assert again.rows[0].cpu_s == pytest.approx(row.cpu_s, rel=1e-4)  # it was not measured again
    assert "--acceleration 5" in (tmp_path / "out" / "motion.md").read_text()


def test_bad_limits_are_refused_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(PlannerError, match="velocity scale 2"):
        bench_motion(problems(tmp_path / "one"), tmp_path / "out", PLAIN, LimitsRequest(velocity_scale=2.0))
    assert not (tmp_path / "out").exists()
