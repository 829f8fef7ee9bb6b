"""``benchmarks plan``: problems, rows, outcomes, the report, and the log that OMPL's own tool reads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.plan import run as bench
from benchmarks.plan.rows import Row
from benchmarks.plan.run import bench_plan
from benchmarks.results import read_rows
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.batch.outcomes import CRASHED, REFUSED, SOLVED, TIMED_OUT
from tests.batch.posts import PLAIN, write_problem


def rows_of(out: Path) -> list[Row]:
    return read_rows(out / "plan.csv", Row, "python -m benchmarks plan")


def test_every_run_has_a_row(out: Path) -> None:
    rows = rows_of(out)
    assert [(r.problem, r.seed, r.outcome) for r in rows] == [
        ("far/0001", 0, REFUSED),
        ("far/0001", 1, REFUSED),
        ("posts/0001", 0, SOLVED),
        ("posts/0001", 1, SOLVED),
    ]
    for row in rows[:2]:
        assert "by 0.0229 rad" in row.message
        assert row.nodes is row.contacts is row.total_s is None
    for row in rows[2:]:
        assert row.certified == row.edges
        assert row.contacts == 0
        assert row.nodes is not None
        assert row.nodes >= 40
        assert row.total_s is not None
        assert row.process_s is not None
        assert row.first_path_s is not None
        assert 0 < row.first_path_s < row.total_s < row.process_s


def test_rows_that_hold_are_not_measured_again(problems: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda run, progress, **_: measured.append(run[1].seed) or [])
    again = bench_plan(problems, out, PLAIN, seeds=(0, 1))
    assert (measured, again.complete, len(again.rows)) == ([], True, 4)
    # another seed, other settings, other software or a limit that a row was over: measured anew
    for change in ({"seeds": (2,)}, {"plain": replace(PLAIN, beta=1.0)}, {"time_limit": 1e-3}):
        measured.clear()
        stopped = bench_plan(problems, out, **{"plain": PLAIN, "seeds": (0,)} | change)  # type: ignore[arg-type]
        assert len(measured) == 1
        assert not stopped.complete
    measured.clear()
    monkeypatch.setattr(bench, "software", lambda: "newer")
    bench_plan(problems, out, PLAIN, seeds=(0,))
    assert measured == [0]


def test_a_changed_problem_is_measured_again(problems: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda run, progress, **_: measured.append(run[0].name) or [])
    write_problem(problems / "far", "0001", (-1.0, 0.8), (1.0, -2.98))
    try:
        bench_plan(problems, out, PLAIN, seeds=(0,))
    finally:
        write_problem(problems / "far", "0001", (-1.0, 0.8), (1.0, -2.99))
    assert measured == ["far/0001"]


def test_the_limit_kills_and_says_so(problems: Path, tmp_path: Path) -> None:
    found = bench_plan(problems / "posts", tmp_path, PLAIN, seeds=(0,), time_limit=0.05)
    assert found.complete
    assert found.rows[0].outcome == TIMED_OUT
    assert "killed after 0.05 s" in found.rows[0].message
    assert "| posts | 1 | 0 | 0 | 0 % | 0 | 1 |" in found.report
    # under a higher limit it is measured again, under a lower one it stays
    assert bench_plan(problems / "posts", tmp_path, PLAIN, seeds=(0,), time_limit=0.04).rows == found.rows
    assert bench_plan(problems / "posts", tmp_path, PLAIN, seeds=(0,), time_limit=100).rows[0].outcome == SOLVED


def test_a_crash_is_a_row(problems: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.bench.json.dumps", lambda value, **options: "{")
    row = bench_plan(problems / "posts", tmp_path, PLAIN, seeds=(0,)).rows[0]
    assert row.outcome == CRASHED
    assert "ended with code 1: json.decoder.JSONDecodeError" in row.message


def test_a_stop_saves_what_there_is(problems: Path, tmp_path: Path) -> None:
    calls = iter([False] * 3)
    found = bench_plan(problems, tmp_path, PLAIN, seeds=(0,), progress=Progress(stop=lambda: next(calls, True)))
    assert not found.complete
    assert found.rows == ()
    assert "Interrupted: the runs that were not measured" in (tmp_path / "plan.md").read_text()


def row(**more) -> Row:
    plain = Row(
        *("posts/1", "posts", 0, "panda", "coal", 1000, 1.0, False, "", 60.0, "abcd", "here", SOLVED, "yes"),
        total_s=2.0,
        process_s=3.0,
        first_path_s=0.3,
        nodes=1000,
        edges=2000,
        certified=2000,
        waypoints=5,
        length_rad=4.0,
        length_m=1.0,
        w_min=0.02,
        w_mean=0.06,
        clearance_m=0.004,
        contacts=0,
        memory_mib=200.0,
    )
    return replace(plain, **more)


def test_wrong_input(problems: Path, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="scene is what each problem says"):
        bench_plan(problems, tmp_path, replace(PLAIN, scene="shelf"))
    with pytest.raises(OptionError, match="time limit"):
        bench_plan(problems, tmp_path, PLAIN, time_limit=0.0)
    with pytest.raises(OptionError, match="at least one seed"):
        bench_plan(problems, tmp_path, PLAIN, seeds=())
    with pytest.raises(OptionError, match="seed -1"):
        bench_plan(problems, tmp_path, PLAIN, seeds=(-1,))
