"""``planner bench tables``: every task is planned by every method, and published numbers stand beside as typed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from planner.base.errors import OptionError
from planner.base.request import PlanRequest
from planner.studies.bench_plan.rows import REFUSED, SOLVED
from planner.studies.bench_tables.case import measure
from planner.studies.bench_tables.methods import KEPT, PATH_ONLY, asked_by
from planner.studies.bench_tables.published import GCS, GCS_TASKS, MBM, PUBLISHED
from planner.studies.bench_tables.report import Row, to_markdown
from planner.studies.bench_tables.run import bench_tables

PLAIN = PlanRequest("iiwa14", GCS, collision="coal", nodes=30, effort=0)


@pytest.mark.parametrize("method", [PATH_ONLY, "beta 1", KEPT])
def test_a_task_by_every_method(method: str) -> None:
    request = asked_by(PLAIN, (1.0,), kept=True)[method]
    (columns,) = measure(method, [("right-bin", "above-shelf")], request)
    assert columns["outcome"] == SOLVED, columns
    assert columns["contacts"] == 0
    assert columns["length_rad"] >= columns["straight_rad"] == pytest.approx(1.66, abs=0.01)
    assert 0 < columns["w_min"] <= columns["w_mean"]
    assert ("built_s" in columns) == (method == KEPT)


def test_a_task_that_is_refused_is_a_row() -> None:
    (columns,) = measure(PATH_ONLY, [("nowhere", "above-shelf")], PLAIN)
    assert columns["outcome"] == REFUSED
    assert "nowhere" in columns["message"]


def test_every_task_has_its_published_numbers() -> None:
    for start, goal in GCS_TASKS:
        of = [one for one in PUBLISHED if (one.table, one.task) == (GCS, f"{start} to {goal}")]
        assert [one.method for one in of] == ["GCS", "PRM", "PRM, short cuts"]
        assert of[0].length_rad < of[2].length_rad < of[1].length_rad
    assert GCS_TASKS[0][0] == GCS_TASKS[-1][1]


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


def test_no_beta_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="at least one beta"):
        bench_tables(tmp_path, betas=())
