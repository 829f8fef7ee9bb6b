"""What the comparison of checkers says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.agreement import run as bench
from benchmarks.agreement.report import aims
from benchmarks.agreement.run import bench_agreement
from planner.collision import make_checker
from tests.benchmarks.agreement.test_run import ball_of, pair_of
from tests.worlds import load


def test_disagreements_are_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the wrong ball for FCL the bench says so in its row, its aims and its report."""
    balls = {"fcl": make_checker(load("planar_2r"), ball_of(0.3), "fcl"), "coal": pair_of()[1]}
    monkeypatch.setattr(bench, "open_world", lambda request: balls[request.collision])
    row = bench_agreement(tmp_path, states=200, robots=("planar_2r",), scenes=("ball",)).rows[0]
    assert row.disagreed == row.unexplained > 5
    assert len(json.loads(row.listed)) == 20
    assert not aims([row])[0].holds
    text = (tmp_path / "agreement.md").read_text()
    assert "Disagreements:" in text
    assert "| planar_2r | ball | fcl | link_2, ball |" in text
