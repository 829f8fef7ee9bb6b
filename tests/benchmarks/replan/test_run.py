"""``benchmarks replan``: a row per change, kept rows, a report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from benchmarks.replan import run as bench
from benchmarks.replan.report import Row
from benchmarks.replan.run import bench_replan
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.batch.results import read_rows
from planner.problem.request import RoadmapRequest
from tests.documents import ROOT

PLAIN = RoadmapRequest("panda", collision="coal", nodes=60)
EXAMPLES = ROOT / "scenes" / "examples"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("bench")
    assert bench_replan(EXAMPLES, place, PLAIN, changes=4, simulations=4).complete
    return place


def test_every_change_has_a_row_that_keeps_the_promises(folder: Path) -> None:
    rows = read_rows(folder / "replan.csv", Row, "python -m benchmarks replan")
    *changed, simulated = rows
    assert {row.kind for row in changed} <= {"moved", "added", "removed", "blocking the route"}
    assert [row.number for row in rows] == list(range(1, len(rows) + 1))
    assert (simulated.kind, simulated.runs, simulated.touched_before) == ("simulated", 4, 0)
    assert changed
    for row in changed:
        assert row.error is not None
        assert row.error <= 1e-9
        assert row.contacts in (0, None)
        assert (row.anew_s is None) == (row.anew_solved is None)
    assert (folder / "replan.md").read_text().startswith("# python -m benchmarks replan")


def test_rows_that_are_there_are_not_measured_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda *rest, **_: measured.append(rest))
    before = (folder / "replan.csv").read_bytes()
    bench_replan(EXAMPLES, folder, PLAIN, changes=4, simulations=4)
    assert measured == []
    assert (folder / "replan.csv").read_bytes() == before


def test_a_stop_leaves_the_rest(tmp_path: Path) -> None:
    found = bench_replan(EXAMPLES, tmp_path, changes=4, progress=Progress(stop=lambda: True))
    assert (found.complete, found.rows) == (False, ())


def test_limits_are_widened_where_that_is_asked_for(tmp_path: Path) -> None:
    """Rows that were measured without say nothing of it; the example's limits, narrowed, are exceeded by its start."""
    problem = (EXAMPLES / "request0001.yaml").read_text()
    request = yaml.safe_load(problem)
    joints = request["start_state"]["joint_state"]
    joints["position"][joints["name"].index("panda_joint4")] = -0.02  # the limit is -0.0698
    (tmp_path / "request0001.yaml").write_text(yaml.safe_dump(request))
    (tmp_path / "scene0001.yaml").write_bytes((EXAMPLES / "scene0001.yaml").read_bytes())
    found = [
        bench_replan(tmp_path, tmp_path / "out", replace(PLAIN, widen_limits=widen), changes=1, simulations=0).rows
        for widen in (False, True)
    ]
    assert [row.outcome == "refused" for (row, *_) in found] == [True, False]


def test_bad_numbers_are_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionError):
        bench_replan(EXAMPLES, tmp_path, changes=0)
