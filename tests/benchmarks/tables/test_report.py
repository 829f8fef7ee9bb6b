"""Ours beside published numbers."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.tables.published import GCS, MBM
from benchmarks.tables.report import Row, to_markdown
from planner.batch.outcomes import REFUSED, SOLVED


def test_the_report_sets_ours_beside_them() -> None:
    row = Row(GCS, "left-bin to right-bin", "beta 1", 30, 0, "coal", "", "software", SOLVED)
    measured = replace(row, seconds=2.0, length_rad=2.99, straight_rad=2.88, w_min=0.119, w_mean=0.121, contacts=0)
    problem = replace(measured, table=MBM, task="box/0001")
    report = to_markdown([measured, problem, replace(problem, task="box/0002", outcome=REFUSED, message="Too far.")])
    assert "| left-bin to right-bin | 3.5 | 6.1 | 3.8 | 2.99 | 2.88 |" in report
    assert "| left-bin to right-bin | 0.14 | 0.21 | 0.51 | 2 |" in report
    assert "| left-bin to right-bin | 0.119 / 0.121 |" in report
    assert "| VAMP RRT-Connect, median, published | 699 | 700 | 7.76 | 3.5e-05 |" in report
    assert "| ours, beta 1, median | 1 | 2 | 2.99 | 2 |" in report
    assert "- box/0002, beta 1: refused. Too far." in report
    assert "- 2 of 2: Every task is solved." in report
    assert "What could not be had" in report
