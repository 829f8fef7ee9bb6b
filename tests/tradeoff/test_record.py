"""What a sweep writes."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np

from planner.roadmap.storage import load_roadmap
from planner.tradeoff.sweep import Tradeoff, sweep

CONTRACT = {"beta_min", "beta_max", "path_nodes", "manipulability_cost", "distance_cost", "w_min", "w_mean"}


def test_the_files(swept: Tradeoff, tmp_path: Path) -> None:
    swept.save(tmp_path)
    record = json.loads((tmp_path / "sweep.json").read_text())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["roadmap.npz", "sweep.csv", "sweep.html", "sweep.json"]
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == record["roadmap"]["sha256"] == swept.roadmap.sha256
    assert {"outcome", "robot", "scene", "seed", "config", "versions", "complete", "solves"} <= set(record)
    assert {"setup", "roadmap", "costs", "gabf", "path", "measures", "total"} <= set(record["timings_s"])
    for written, interval in zip(record["intervals"], swept.intervals, strict=True):
        assert set(written) >= CONTRACT | {"workspace_length"}
        assert all(written[key] == getattr(interval, key) for key in CONTRACT - {"path_nodes"})
        assert written["path_nodes"] == interval.path_nodes.tolist()
        np.testing.assert_array_equal(written["path"], interval.path)


def test_the_table_holds_the_same_numbers(swept: Tradeoff, tmp_path: Path) -> None:
    swept.save(tmp_path)
    with (tmp_path / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row, interval in zip(rows, swept.to_dict()["intervals"], strict=True):
        assert [int(node) for node in row.pop("path_nodes").split()] == interval["path_nodes"]
        assert {name: float(value) for name, value in row.items()} == {name: interval[name] for name in row}
        assert set(row) >= CONTRACT - {"path_nodes"}


def test_the_same_request_gives_the_same_files(swept: Tradeoff, tmp_path: Path) -> None:
    twice = sweep(swept.request)
    records = [found.to_dict() for found in (swept, twice)]
    for record in records:
        record.pop("timings_s")
    assert records[0] == records[1]


def test_what_the_terminal_says(swept: Tradeoff) -> None:
    rows = swept.record.table
    assert len(rows) == len(swept.intervals)
    assert rows[0]["beta"].startswith("0 - ")
    assert rows[-1]["beta"].endswith(" - 1")
    assert rows[0]["Omega"] == f"{swept.intervals[0].manipulability_cost:.4f}"
    text = "\n".join(swept.record.lines)
    assert "150 nodes" in text
    assert f"{swept.solves} fields solved" in text
