"""One plan of a batch: the columns of its row, and the files of its folder."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planner.batch.case import main
from planner.batch.outcomes import REFUSED
from planner.planning.plan import plan
from tests.batch.test_run import PLAIN

ASKED = {"robot": "planar_2r", "scene": "empty", "nodes": 40, "collision": "coal"}


def test_the_row_is_the_plan_and_the_folder_holds_it(tmp_path: Path) -> None:
    main(str(tmp_path / "row.json"), str(tmp_path / "one"), json.dumps(ASKED))
    row = json.loads((tmp_path / "row.json").read_text())
    found = plan(PLAIN)
    assert found.cost is not None
    assert (row["outcome"], row["nodes"], row["roadmap_sha256"]) == ("solved", 40, found.roadmap.sha256)
    assert row["cost"] == pytest.approx(found.cost.total, rel=1e-12)
    assert row["waypoints"] == len(found.path)
    written = {path.name for path in (tmp_path / "one").iterdir()}
    assert {"plan.json", "roadmap.npz"} <= written
    assert "plan.html" not in written


def test_paths_come_back_from_json_and_a_refusal_is_a_row(tmp_path: Path) -> None:
    missing = ASKED | {"roadmap": str(tmp_path / "none.npz")}
    main(str(tmp_path / "row.json"), str(tmp_path / "two"), json.dumps(missing))
    row = json.loads((tmp_path / "row.json").read_text())
    assert row["outcome"] == REFUSED
    assert "none.npz not found" in row["message"]
