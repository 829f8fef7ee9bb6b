"""What is written of a sweep: files that agree, a record as its schema says, a page of its paths, ends in words."""

import csv
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.problem.request import SweepRequest
from planner.roadmap.storage import load_roadmap
from planner.tradeoff.result import Tradeoff, range_text
from planner.tradeoff.sweep import sweep
from tests.planning.records import SMALL, as_written, spoilt
from tests.random_shapes import QUICK

CONTRACT = {"beta_min", "beta_max", "path_nodes", "manipulability_cost", "distance_cost", "w_min", "w_mean"}
CONTRACT |= {"duration", "clearance", "gain", "added_length"}


def test_the_files_hold_the_same_numbers(swept: Tradeoff, tmp_path: Path) -> None:
    swept.save(tmp_path)
    motions = [f"trajectory-{k + 1}.json" for k in range(len(swept.intervals))]
    files = ["roadmap.npz", "sweep.csv", "sweep.html", "sweep.json", *motions]
    assert sorted(path.name for path in tmp_path.iterdir()) == files
    record = json.loads((tmp_path / "sweep.json").read_text())
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == record["roadmap"]["sha256"] == swept.roadmap.sha256
    assert {"outcome", "robot", "scene", "seed", "config", "versions", "complete", "solves"} <= set(record)
    assert {"setup", "roadmap", "costs", "gabf", "path", "measures", "total"} <= set(record["timings_s"])
    with (tmp_path / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row, written, interval in zip(rows, record["intervals"], swept.intervals, strict=True):
        assert set(written) >= CONTRACT | {"workspace_length"}
        assert all(written[key] == getattr(interval, key) for key in CONTRACT - {"path_nodes"})
        assert written["path_nodes"] == interval.path_nodes.tolist()
        np.testing.assert_array_equal(written["path"], interval.path)
        assert [int(node) for node in row.pop("path_nodes").split()] == written["path_nodes"]
        assert {name: float(value) for name, value in row.items()} == {name: written[name] for name in row}
        assert set(row) >= CONTRACT - {"path_nodes"}


@pytest.mark.parametrize("validator", ["sweep"], indirect=True)
def test_sweeps_are_as_the_schema_says(validator: jsonschema.Draft202012Validator) -> None:
    record = as_written(sweep(request=SweepRequest.from_options(**SMALL)).to_dict())
    validator.validate(record)
    assert not any(validator.is_valid(each) for each in spoilt(record))


@QUICK
@given(st.floats(0, 1), st.floats(0, 1))
def test_intervals_in_words_are_true_and_have_two_ends(low: float, high: float) -> None:
    low, high = sorted((low, high))
    first, last = range_text(low, high).split(" to ")
    apart = high - low
    allowed = max(0.1 * apart, 5.1e-13) if apart else 5.1e-4
    assert abs(float(first) - low) <= allowed
    assert abs(float(last) - high) <= allowed
    assert first != last or apart < 1e-11
