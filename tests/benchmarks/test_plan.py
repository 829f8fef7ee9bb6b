"""``benchmarks plan``: what a row counts is there, and what was asked otherwise is measured anew."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.looks import path_contacts
from benchmarks.plan.report import aims, compare, fault
from benchmarks.plan.run import BENCH
from benchmarks.plan.run import plan as bench_plan
from benchmarks.results import Row, read_rows
from planner.batch.run import CRASHED, SOLVED, TIMED_OUT
from planner.collision import make_checker
from planner.problem.request import LimitsRequest, PlanRequest
from planner.robot.poses import pose
from planner.robot.shapes import Box
from tests.batch.posts import PLAIN, write_problem
from tests.worlds import load, scene_of

LIMITS = LimitsRequest(acceleration=5.0)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_problem(tmp_path / "posts", "0001", (-1.0, 0.8), (1.0, -0.8))
    return tmp_path / "posts"


def rows_of(folder: Path, out: Path, plain: PlanRequest = PLAIN, **more) -> list[Row]:
    assert bench_plan(folder, plain, LIMITS, out, **{"seeds": (0,)} | more) == 0
    return read_rows(out / "plan.csv", "python -m benchmarks plan")


def test_a_planted_contact_is_counted() -> None:
    """A wall stands in the first of two segments, a hair in the second."""
    parts = [(Box((0.3, 0.05, 0.2)), pose([0.7, 0.0, 0.0])), (Box((0.3, 0.0005, 0.2)), pose([0.0, 0.7, 0.0]))]
    judge = make_checker(load("planar_2r"), scene_of(*parts), "coal")
    path = np.array([[-0.6, 0.0], [0.6, 0.0], [2.2, 0.0], [2.4, 0.0]])
    found = path_contacts(judge, path)
    assert [text.split(" at ")[0] for text in found] == ["segment 0", "segment 1"]
    assert path_contacts(judge, path[2:]) == []


def test_another_limit_and_a_changed_problem_are_measured_anew(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (late,) = rows_of(folder, out, time_limit=0.05)
    assert late.outcome == TIMED_OUT
    assert "killed after 0.05 s" in fault(late)
    rows = rows_of(folder, out)
    assert [row.outcome for row in rows] == [TIMED_OUT, SOLVED]
    assert rows_of(folder, out) == rows
    write_problem(folder, "0001", (-1.0, 0.8), (1.0, -0.7))
    changed = rows_of(folder, out)
    assert changed[:2] == rows
    assert changed[2].content != rows[1].content
    text = (out / "plan.md").read_text()
    assert text.count("- 1 of 1: Every problem") == 1  # the report is about the present problem alone


def test_a_crash_is_a_row(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.bench.json.dumps", lambda value, **more: "{")
    (row,) = rows_of(folder, tmp_path / "out")
    assert row.outcome == CRASHED
    assert "JSONDecodeError" in row.message


def solved(problem: str, method: str = "planner", **more) -> Row:
    row = Row(problem=problem, kind="posts", method=method, seed=0, robot="panda", collision="coal", beta=1.0)
    row |= {"nodes_asked": 1000 if method == "planner" else 0, "widen_limits": False, "options": "", "limits": ""}
    row |= {"software": "here", "outcome": SOLVED, "total_s": 2.0, "certified": 9, "edges": 9, "contacts": 0}
    return Row({**row, "timed_s": 1.0, "proven": True, "largest_share": 0.9, **more})


def test_ratios_are_medians_over_the_problems_that_both_solved() -> None:
    base = [solved(name, "RRTConnect", length_rad=2.0, w_mean=1.0) for name in "abc"]
    ours = [
        solved(name, length_rad=length, w_mean=1.0, corners=2) for name, length in (("a", 1.0), ("b", 1.6), ("d", 9.0))
    ]
    line = compare("RRTConnect", base, "ours", ours)
    assert line[:4] == ["ours", "RRTConnect", 2, pytest.approx(0.65)]
    assert line[-2:] == [1, 1]
    met = {aim.sentence: aim for aim in aims(ours, [*base, *ours]) if aim.of}
    assert all(aim.holds for aim in met.values())
    assert any("0.97 of RRTConnect's" in sentence for sentence in met)
    bad = [Row(row, contacts=1, motion_contact="'a' and 'b'", largest_share=1.1, proven=False) for row in ours]
    assert sum(aim.confirmed == 0 for aim in aims(bad, [*base, *bad]) if aim.of) == 4
    assert "1 segments touch" in fault(bad[0])
    assert "| posts | 3 | 0 | 3 | 100 % | 3 |" in BENCH.report(ours)
