"""``planner batch``: the same rows for any workers, resuming, plans that crash, die, take too long or are stopped."""

import csv
import json
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.batch import run as module
from planner.batch.run import CRASHED, NO_PATH, REFUSED, SOLVED, TIMED_OUT, BatchResult, run_batch
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from tests.batch.test_parallel import TWO, until

PLAIN = PlanRequest.from_options(robot="planar_2r", scene="empty", nodes=40, collision="coal")
PLANS = """plans:
  - {name: one}
  - {name: far/two, goal: "q:0.3,0.4", beta: 0.2}
  - {name: bad, goal: "q:3,9"}
"""
LONG = "  - {name: long, nodes: 100000, robot: iiwa14, scene: paper}\n"


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "batch.yaml"
    path.write_text(PLANS)
    return path


def timeless(batch: BatchResult) -> list[dict[str, Any]]:
    return [row | {"seconds": None} for row in batch.rows]


def test_rows_and_folders_are_the_same_for_any_workers(source: Path, tmp_path: Path) -> None:
    here, there = (run_batch(source, tmp_path / str(jobs), PLAIN, who) for jobs, who in ((1, module.SERIAL), (2, TWO)))
    assert timeless(here) == timeless(there)
    assert [row["outcome"] for row in here.rows] == [SOLVED, SOLVED, REFUSED]
    assert "outside its limits" in here.rows[2]["message"]
    for name in ("one", "far/two"):
        first, second = (json.loads((tmp_path / jobs / name / "plan.json").read_text()) for jobs in "12")
        assert first["path"] == second["path"]
    direct = plan(request=PLAIN.with_options(goal="q:0.3,0.4", beta=0.2), timing=None)
    assert (here.rows[1]["cost"], here.rows[1]["roadmap_sha256"]) == (direct.cost.total, direct.roadmap.sha256)
    assert here.rows[1]["waypoints"] == len(direct.path)
    with (tmp_path / "1" / "batch.csv").open(newline="") as file:
        as_text = [{k: "" if v is None else str(v) for k, v in row.items()} for row in here.rows]
        assert list(csv.DictReader(file)) == as_text


def planned(source: Path, out: Path, monkeypatch: pytest.MonkeyPatch, *outcomes: str) -> list[str]:
    """The folders of the plans that a batch plans now, which end with these outcomes."""
    folders: list[str] = []

    def answer(request: PlanRequest, progress: Progress, folder: Path, pages: bool) -> dict[str, Any]:
        folders.append(folder.name)
        return {"outcome": outcomes[len(folders) - 1], "w_min": 0.1, "length_rad": 1.0}

    monkeypatch.setattr(module, "_plan", answer)
    run_batch(source, out, PLAIN)
    return folders


def test_only_missing_and_failed_plans_are_planned_again(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    again = partial(planned, source, tmp_path / "out", monkeypatch)
    assert again(SOLVED, CRASHED, TIMED_OUT) == ["one", "two", "bad"]
    assert again(NO_PATH, REFUSED) == ["two", "bad"]
    source.write_text(PLANS.replace("beta: 0.2", "beta: 0.3"))
    assert again(SOLVED) == ["two"]
    for damaged in ('{"name": ', "[]", "7", '{"name": "one"}'):
        (tmp_path / "out" / "one" / "row.json").write_text(damaged)
        assert again(SOLVED) == ["one"]
    assert again() == []
    monkeypatch.setattr(module, "software", lambda: "another planner")
    assert again(SOLVED, SOLVED, SOLVED) == ["one", "two", "bad"]


def test_a_plan_that_kills_its_process_is_a_row_and_is_planned_again(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        module, "measure_cases", lambda tasks, work, *more: ((k, None) for k in range(len(tasks)) if k == 1)
    )
    found = run_batch(source, tmp_path / "out", PLAIN)
    assert [row["outcome"] for row in found.rows] == [CRASHED]
    assert "worker died" in found.rows[0]["message"]
    monkeypatch.undo()
    assert [row["outcome"] for row in run_batch(source, tmp_path / "out", PLAIN).rows] == [SOLVED, SOLVED, REFUSED]


def test_a_plan_stops_at_its_time_limit(source: Path, tmp_path: Path) -> None:
    source.write_text(f"plans:\n{LONG}")
    (row,) = run_batch(source, tmp_path / "out", PLAIN, time_limit=1.0).rows
    assert row["outcome"] == TIMED_OUT
    assert row["seconds"] >= 1.0
    assert [path.name for path in (tmp_path / "out" / "long").iterdir()] == ["row.json"]
    with pytest.raises(OptionError, match="time limit"):
        run_batch(source, tmp_path, PLAIN, time_limit=0)


def test_ctrl_c_saves_the_rows_and_ends_the_workers(source: Path, tmp_path: Path) -> None:
    psutil = pytest.importorskip("psutil")
    one = "plans:\n  - {name: one, robot: planar_2r, scene: empty, nodes: 40}\n"
    source.write_text(one + LONG)
    words = [sys.executable, "-m", "planner", "batch", str(source), "--out", str(tmp_path / "out"), "--jobs", "2"]
    command = subprocess.Popen(words, start_new_session=True)
    until((tmp_path / "out" / "one" / "row.json").exists)
    workers = psutil.Process(command.pid).children(recursive=True)
    os.killpg(command.pid, signal.SIGINT)  # as a terminal does
    assert command.wait(timeout=120) == 130
    assert not psutil.wait_procs(workers, timeout=120)[1]
    with (tmp_path / "out" / "batch.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["one"]
    source.write_text(one)
    assert str(run_batch(source, tmp_path / "out", PlanRequest()).rows[0]["seconds"]) == rows[0]["seconds"]
