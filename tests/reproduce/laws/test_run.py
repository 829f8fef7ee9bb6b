"""``python -m reproduce laws``: a small whole run."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.progress import Progress
from reproduce.laws.cases import CASES, FREE, PRESCRIBED, Trace
from reproduce.laws.run import history_rows, law_table, run_laws, study_graph
from reproduce.report import Report, write_report
from tests.reproduce.laws.test_claims import study


@pytest.fixture(scope="module")
def small() -> Report:
    return run_laws(graphs=2, nodes=60, seed=1)


def test_a_small_run_is_whole(small: Report, tmp_path: Path) -> None:
    assert small.complete
    assert len(small.table) == len(CASES)
    assert all(row["graphs"] == row["settled"] == 2 for row in small.table)
    assert len(small.more["runs"]) == 2 * len(CASES)
    write_report(small, tmp_path)
    record = json.loads((tmp_path / "laws.json").read_text())
    assert all({"sentence", "confirmed", "of", "note"} == set(verdict) for verdict in record["verdicts"])
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*record["figures"], "laws.json"])
    assert len(record["figures"]) == 4
    for name in record["figures"]:
        assert (tmp_path / name).read_bytes()[:4] == b"\x89PNG"


def test_what_must_hold_on_any_graph_holds(small: Report) -> None:
    certain = ("converge", "remain bounded", "Larger h leads", "(ours) Every bound", "overestimated")
    for verdict in small.verdicts:
        if any(word in verdict.sentence for word in certain) and "faster convergence (s" not in verdict.sentence:
            assert verdict.holds, verdict


def test_a_graph_does_not_depend_on_how_many_are_drawn(small: Report) -> None:
    rows = [row for row in small.more["runs"] if row["graph"] == 1]
    assert [row["settling_tau"] for row in rows] == [run.settling_tau for run in study_graph(1, 60, 1).runs]


def test_a_stop_before_the_first_graph_leaves_an_empty_report(tmp_path: Path) -> None:
    report = run_laws(graphs=1, nodes=60, progress=Progress(stop=lambda: True))
    assert not report.complete
    assert report.table == ()
    assert all(verdict.of == 0 for verdict in report.verdicts)
    write_report(report, tmp_path)


def test_the_table_has_medians_and_maxima() -> None:
    good = study()
    first, *rest = good.runs
    studies = [replace(good, runs=(replace(first, largest_input=float(k)), *rest)) for k in range(3)]
    row = law_table(studies)[0]
    assert (row["largest_input"], row["largest_input_max"], row["graphs"], row["h"]) == (1.0, 2.0, 3, 1.0)


def test_a_row_of_panels_holds_one_parameter_and_varies_the_other() -> None:
    t = np.array([0.0, 1.0])
    ((title, curves),) = history_rows([Trace(case, 4, (t, t, t)) for case in PRESCRIBED])
    assert (title, list(curves)) == ("", ["h = 1", "h = 2", "h = 4", "h = 8"])
    above = history_rows([Trace(case, 4, (t, t, t)) for case in FREE if case.start == "above"])
    assert [title for title, _ in above] == ["m1/m2 = 9/7", "p1/p2 = 3/5"]
    assert [len(curves) for _, curves in above] == [4, 4]
