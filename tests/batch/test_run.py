"""``planner batch``: what is asked for, rows that do not depend on the number of jobs, resuming, killed processes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.batch import run as module
from planner.batch.outcomes import CRASHED, REFUSED, SOLVED, TIMED_OUT
from planner.batch.results import Results, read_rows
from planner.batch.run import Row, run_batch
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, WorkersRequest
from planner.processes.process import Ended, run_module

PLAIN = PlanRequest(robot="planar_2r", scene="empty", nodes=40, collision="coal")
PLANS = """plans:
  - {name: one}
  - {name: far/two, goal: "q:0.3,0.4", beta: 0.2}
  - {name: bad, goal: "q:3,9"}
"""


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "batch.yaml"
    path.write_text(PLANS)
    return path


def timeless(batch: Results[Row]) -> list[Row]:
    return [replace(row, seconds=None) for row in batch.rows]


def test_rows_and_folders_are_the_same_for_any_number_of_jobs(source: Path, tmp_path: Path) -> None:
    one, three = (run_batch(source, tmp_path / str(jobs), PLAIN, WorkersRequest(jobs)) for jobs in (1, 3))
    assert timeless(one) == timeless(three)
    assert [row.outcome for row in one.rows] == [SOLVED, SOLVED, REFUSED]
    assert "outside its limits" in one.rows[2].message
    for name in ("one", "far/two"):
        plans = [json.loads((tmp_path / jobs / name / "plan.json").read_text()) for jobs in "13"]
        assert plans[0]["path"] == plans[1]["path"]
    # against the planner itself, and as the file holds them
    direct = plan(replace(PLAIN, goal="q:0.3,0.4", beta=0.2))
    assert direct.cost is not None
    assert (one.rows[1].cost, one.rows[1].roadmap_sha256) == (direct.cost.total, direct.roadmap.sha256)
    assert read_rows(tmp_path / "1" / "batch.csv", Row, "planner batch") == list(one.rows)


def answers(monkeypatch: pytest.MonkeyPatch, *codes: int | None) -> list[str]:
    """Processes that end with these codes, 0 with a solved row; returns the folders that were asked for."""
    asked: list[str] = []
    left = list(codes)

    def run(name: str, arguments: list[str], progress: Progress, time_limit: float, tries: int) -> Ended:
        asked.append(Path(arguments[1]).name)
        code = left.pop(0)
        if code == 0:
            Path(arguments[0]).write_text(json.dumps({"outcome": SOLVED, "w_min": 0.1, "length_rad": 1.0}))
        return Ended(code, 1.0, code is None, "words")

    monkeypatch.setattr(module, "run_module", run)
    return asked


def test_what_is_there_is_kept_and_what_failed_is_planned_again(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    asked = answers(monkeypatch, 0, 1, None)
    first = run_batch(source, out, PLAIN)
    assert [row.outcome for row in first.rows] == [SOLVED, CRASHED, TIMED_OUT]
    assert asked == ["one", "two", "bad"]
    asked = answers(monkeypatch, 0, 0)
    second = run_batch(source, out, PLAIN)
    assert (asked, second.rows[0]) == (["two", "bad"], first.rows[0])
    assert [row.outcome for row in second.rows] == [SOLVED] * 3
    source.write_text(PLANS.replace("beta: 0.2", "beta: 0.3"))
    asked = answers(monkeypatch, 0)
    run_batch(source, out, PLAIN)
    assert asked == ["two"]
    row = (out / "one" / "row.json").read_text()
    changed = ({"w_min": None}, {"w_min": float("nan")}, {"message": "\ud800"})
    rows = (json.dumps(json.loads(row) | change) for change in changed)
    for damaged in ('{"name": ', "[" * 100_000, row.replace('"seconds": ', '"seconds": [], "seconds_": '), *rows):
        (out / "one" / "row.json").write_text(damaged)
        asked = answers(monkeypatch, 0)
        run_batch(source, out, PLAIN)
        assert asked == ["one"]


def test_a_mesh_that_a_scene_names_is_part_of_what_is_asked(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh, scene = tmp_path / "part.obj", tmp_path / "cell.yaml"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene.write_text("obstacles: [{name: part, type: mesh, file: part.obj}]\n")
    source.write_text("plans: [{name: one, scene: cell.yaml}]")
    for expected in (["one"], []):
        asked = answers(monkeypatch, 0)
        run_batch(source, tmp_path / "out", PLAIN)
        assert asked == expected
    mesh.write_text(mesh.read_text().replace("v 1 0 0", "v 1.5 0 0"))
    asked = answers(monkeypatch, 0)
    run_batch(source, tmp_path / "out", PLAIN)
    assert asked == ["one"]


def test_a_process_that_the_system_kills_costs_no_other_row(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Real processes: one kills itself at every try, beside two that plan."""
    (tmp_path / "killed.py").write_text("import os, signal; os.kill(os.getpid(), signal.SIGKILL)")
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")

    def run(name: str, arguments: list[str], *rest: Any, **more: Any) -> Ended:
        return run_module("killed" if Path(arguments[1]).name == "bad" else name, arguments, *rest, **more)

    monkeypatch.setattr(module, "run_module", run)
    done = run_batch(source, tmp_path / "out", PLAIN, WorkersRequest(2))
    assert [row.outcome for row in done.rows] == [SOLVED, SOLVED, CRASHED]
    assert "code -9" in done.rows[2].message


def test_an_interrupted_batch_goes_on(source: Path, tmp_path: Path) -> None:
    done: list[int] = []

    def progress_until(stop: Callable[[], bool]) -> Progress:
        return Progress(lambda stage, k, of: done.append(k), stop)

    first = run_batch(source, tmp_path / "out", PLAIN, progress=progress_until(lambda: max(done, default=0) >= 1))
    assert (first.complete, len(first.rows)) == (False, 1)
    assert "goes on from here" in first.report
    second = run_batch(source, tmp_path / "out", PLAIN, WorkersRequest(2))
    assert second.complete
    assert second.rows[0] == first.rows[0]


def test_jobs_and_time_limit_in_range(source: Path, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="0 jobs"):
        WorkersRequest(0)
    with pytest.raises(OptionError, match="time limit"):
        run_batch(source, tmp_path, PLAIN, time_limit=0)
