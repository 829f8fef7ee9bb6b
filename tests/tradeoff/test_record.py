"""What a sweep writes, and what it goes on from."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.base.beside import mismatch
from planner.base.errors import FileError
from planner.base.formats import FORMAT_VERSION
from planner.problem.request import SweepRequest
from planner.roadmap.storage import load_roadmap
from planner.tradeoff.nondominated import MAX_LABELS
from planner.tradeoff.record import interval_rows, read_checkpoint, save_sweep, summary_lines, sweep_record
from planner.tradeoff.sweep import Tradeoff, sweep
from tests.planning.records import SMALL
from tests.tradeoff.test_sweep import refused


def test_a_sweep_of_a_newer_planner_is_not_gone_on_from(tmp_path: Path) -> None:
    request = SweepRequest(**SMALL)
    record = save_sweep(sweep(request), tmp_path)
    read_checkpoint(request, tmp_path)
    (tmp_path / "sweep.json").write_text(json.dumps({**record, "format_version": FORMAT_VERSION + 1}))
    with pytest.raises(FileError, match="update the planner"):
        read_checkpoint(request, tmp_path)


@pytest.fixture
def kept(swept: Tradeoff, tmp_path: Path) -> Path:
    save_sweep(swept, tmp_path)
    return tmp_path


def test_another_request_is_refused(swept: Tradeoff, kept: Path) -> None:
    refused(replace(swept.request, seed=3), kept, r"was made with --seed 2, not 3: repeat its options")
    refused(replace(swept.request, roadmap=kept / "r.npz"), kept, r"was made with --roadmap None, not '.*r.npz'")
    refused(replace(swept.request, manipulability_cost="linear"), kept, r"--manipulability-cost 'log', not 'linear'")


def test_a_folder_without_a_sweep_is_refused(swept: Tradeoff, tmp_path: Path) -> None:
    refused(swept.request, tmp_path, r"sweep.json not found, so there is no sweep to go on from: leave --resume out")


def _ends(record: dict[str, Any]) -> list[Any]:
    """The first and the last path, as if there were none between."""
    return record["search"]["found"][:: len(record["search"]["found"]) - 1]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda record: record["search"].update(settled=99), "not in the order of beta"),
        (lambda record: record["search"]["found"].reverse(), "not in the order of beta"),
        (lambda record: record["search"]["found"].pop(), "not in the order of beta"),
        (lambda record: record["search"]["found"][0].update(path_nodes=[]), "path_nodes"),
        (lambda record: record["search"]["found"][0].update(beta="much"), "beta"),
        (lambda record: record.pop("search"), "'search' is missing"),
        (lambda record: record["search"]["found"][1].update(path_nodes=[0, 1]), "does not fit its roadmap"),
        (lambda record: record["search"]["found"][0].update(record["search"]["found"][-1], beta=0.0), "is not optimal"),
        (
            lambda record: record["search"].update(found=_ends(record), settled=1),
            "beta 0 and 1 another path is cheaper",
        ),
        (lambda record: record["roadmap"].update(sha256="0"), "made on another roadmap than the one beside it"),
    ],
)
def test_damage_is_named(swept: Tradeoff, kept: Path, change: Callable[[dict[str, Any]], Any], text: str) -> None:
    record = json.loads((kept / "sweep.json").read_text())
    change(record)
    (kept / "sweep.json").write_text(json.dumps(record))
    refused(swept.request, kept, text)


@pytest.mark.parametrize("content", ["", "{", "[]", "\x00", "[" * 100_000])
def test_what_is_no_sweep_is_named(swept: Tradeoff, kept: Path, content: str) -> None:
    (kept / "sweep.json").write_text(content)
    refused(swept.request, kept, "sweep.json")


CONTRACT = {"beta_min", "beta_max", "path_nodes", "manipulability_cost", "distance_cost", "w_min", "w_mean"}


def test_the_files(swept: Tradeoff, tmp_path: Path) -> None:
    record = save_sweep(swept, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["roadmap.npz", "sweep.csv", "sweep.html", "sweep.json"]
    assert json.loads((tmp_path / "sweep.json").read_text()) == record
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == record["roadmap"]["sha256"] == swept.roadmap.sha256
    assert sorted(record["files"]) == ["roadmap.npz", "sweep.csv", "sweep.html"]
    assert mismatch(tmp_path / "sweep.json") is None
    (tmp_path / "sweep.csv").write_text("of another")
    assert "written with another sweep.csv" in (mismatch(tmp_path / "sweep.json") or "")
    assert {"outcome", "robot", "scene", "seed", "config", "versions", "complete", "solves"} <= set(record)
    assert {"setup", "roadmap", "costs", "gabf", "path", "measures", "front", "total"} <= set(record["timings_s"])
    for written, interval in zip(record["intervals"], swept.intervals, strict=True):
        assert set(written) >= CONTRACT | {"workspace_length"}
        assert all(written[key] == getattr(interval, key) for key in CONTRACT - {"path_nodes"})
        assert written["path_nodes"] == interval.path_nodes.tolist()
        np.testing.assert_array_equal(written["path"], interval.path)
    front = record["front"]
    assert front["beyond_every_beta"] == sum(not point["optimal_at_some_beta"] for point in front["points"]) > 0


def test_the_table_holds_the_same_numbers(swept: Tradeoff, tmp_path: Path) -> None:
    record = save_sweep(swept, tmp_path)
    with (tmp_path / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row, interval in zip(rows, record["intervals"], strict=True):
        assert [int(node) for node in row.pop("path_nodes").split()] == interval["path_nodes"]
        assert {name: float(value) for name, value in row.items()} == {name: interval[name] for name in row}
        assert set(row) >= CONTRACT - {"path_nodes"}


def test_the_same_request_gives_the_same_files(swept: Tradeoff, tmp_path: Path) -> None:
    twice = sweep(swept.request, front=True, max_labels=MAX_LABELS)
    records = [sweep_record(found) for found in (swept, twice)]
    for record in records:
        record.pop("timings_s")
    assert records[0] == records[1]


def test_what_the_terminal_says(swept: Tradeoff) -> None:
    record = sweep_record(swept)
    rows = interval_rows(record)
    assert len(rows) == len(swept.intervals)
    assert rows[0]["beta"].startswith("0 - ")
    assert rows[-1]["beta"].endswith(" - 1")
    assert rows[0]["Omega"] == f"{swept.intervals[0].manipulability_cost:.4f}"
    text = "\n".join(summary_lines(record))
    assert "150 nodes" in text
    assert f"{swept.solves} fields solved" in text
    points = record["front"]["points"]
    beyond = [point for point in points if not point["optimal_at_some_beta"]]
    assert f"{len(points)} non-dominated paths, {len(beyond) or 'none'} of them out of reach of every beta" in text
