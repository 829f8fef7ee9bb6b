"""One problem of the benchmark of replanning: a row per change, each judged by other means."""

from __future__ import annotations

import pytest

from benchmarks.replan import case
from benchmarks.replan.case import measure
from benchmarks.replan.changes import KINDS
from planner.problem.request import RoadmapRequest
from tests.worlds import load, make_post

REQUEST = RoadmapRequest(
    load("planar_2r"), make_post().world.scene, start="q:-1,0.8", goal="q:1,-0.8", nodes=30, collision="coal"
)


def test_rows_hold_what_was_measured() -> None:
    rows = measure(REQUEST, changes=2, simulations=0)
    assert {row["kind"] for row in rows} <= set(KINDS)
    assert rows
    for row in rows:
        assert row["error"] <= 1e-9
        assert row.get("contacts", 0) == 0
        assert row["anew_solved"] in (True, False)
        if "lifelong_error" in row:
            assert row["lifelong_error"] <= 1e-9
            assert row["lifelong_to_start"] <= row["lifelong_updates"]
        if row["outcome"] == "solved" and row["nodes_grown"] == 0:
            assert row["seconds"] > 0


def test_later_changes_are_measured_but_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(case, "_COMPARED", 1)
    first, *later = measure(REQUEST, changes=6, simulations=0)
    assert first["anew_solved"] in (True, False)
    assert len(later) > 1
    for row in later:
        assert "anew_s" not in row
        assert row["error"] <= 1e-9
        assert row["memory_mib"] is None or row["memory_mib"] > 10
