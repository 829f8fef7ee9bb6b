"""``benchmarks scaling``: a row for each number of jobs, kept, and what the report says of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.scaling import run as module
from benchmarks.scaling.run import bench_scaling
from planner.base.errors import OptionError
from tests.batch.test_run import PLAIN

PLANS = "plans:\n  - {name: one}\n  - {name: two, beta: 0.2}\n"


def test_every_number_of_jobs_has_a_row_that_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    source = tmp_path / "batch.yaml"
    source.write_text(PLANS)
    found = bench_scaling(source, tmp_path / "out", PLAIN, jobs=(1, 2))
    assert [(row.jobs, row.plans, len(row.seconds)) for row in found.rows] == [(1, 2, 2), (2, 2, 2)]
    for row in found.rows:
        assert row.wall_s is not None
        assert row.dispatch_s is not None
        assert max(row.seconds) <= row.wall_s
        assert row.dispatch_s < 0.05
    assert "100 workers" in found.report
    assert sorted(p.name for p in tmp_path.iterdir()) == ["batch.yaml", "out"]
    monkeypatch.setattr(module, "_measure", lambda *_, **__: [])  # nothing is measured again
    assert bench_scaling(source, tmp_path / "out", PLAIN, jobs=(1, 2)).rows == found.rows


def test_numbers_that_make_no_sense_are_refused(tmp_path: Path) -> None:
    source = tmp_path / "batch.yaml"
    source.write_text(PLANS)
    for jobs in ((1, 1), (3,), (0,)):
        with pytest.raises(OptionError):
            bench_scaling(source, tmp_path / "out", PLAIN, jobs=jobs)
