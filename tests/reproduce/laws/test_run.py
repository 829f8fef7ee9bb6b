"""``planner reproduce laws``: the verdict logic on doctored measurements, and a small whole run."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.reproduce.laws import run as experiment
from planner.reproduce.laws.cases import CASES, FREE, PRESCRIBED, LawCase, Measurement
from planner.reproduce.laws.near_deadline import TRIALS
from planner.reproduce.laws.run import law_table, run_laws
from planner.reproduce.report import Report, write_report


@pytest.fixture(scope="module")
def small() -> Report:
    return run_laws(graphs=2, nodes=60, seed=1)


def ideal(graph: int, case: LawCase) -> Measurement:
    """A measurement on which every sentence of the paper is true."""
    if case in PRESCRIBED:
        h = PRESCRIBED.index(case)
        time, effort = 3.5 - 0.1 * h, 10.0 + h
    else:
        k = FREE.index(case) % 16
        time, effort = 1.0 + 0.1 * (k // 4) + 0.01 * (k % 4), 20.0 - (k // 4) - 0.1 * (k % 4)
    return Measurement(graph, case, 10 * time, time, 0.1, effort, effort, 0.0, effort, effort, effort, 0.0, True)


def test_a_small_run_is_whole(small: Report, tmp_path: Path) -> None:
    assert small.complete
    assert len(small.table) == len(CASES)
    assert all(row["graphs"] == row["settled"] == 2 for row in small.table)
    assert len(small.more["runs"]) == 2 * len(CASES)
    assert len(small.more["trials"]) == 2 * len(TRIALS)
    write_report(small, tmp_path)
    record = json.loads((tmp_path / "laws.json").read_text())
    assert all({"sentence", "confirmed", "of", "note"} == set(verdict) for verdict in record["verdicts"])
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*record["figures"], "laws.json"])
    for name in record["figures"]:
        assert (tmp_path / name).read_bytes()[:4] == b"\x89PNG"


def test_what_must_hold_on_any_graph_holds(small: Report) -> None:
    certain = ("converge", "remain bounded", "Larger h leads", "(ours) Every bound", "overestimated")
    for verdict in small.verdicts:
        if any(word in verdict.sentence for word in certain) and "faster convergence (s" not in verdict.sentence:
            assert verdict.holds, verdict


def test_a_graph_does_not_depend_on_how_many_are_drawn(small: Report) -> None:
    alone = experiment._study_graph(1, QUIET, 60, 1)
    assert alone is not None
    rows = [row for row in small.more["runs"] if row["graph"] == 1]
    assert [row["settling_tau"] for row in rows] == [run.settling_tau for run in alone.runs]


def test_progress_is_told_and_a_stop_keeps_whole_graphs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experiment, "run_trials", lambda graph, k: iter(()))
    heard = []
    report = run_laws(
        graphs=5,
        nodes=60,
        progress=Progress(
            lambda stage, done, total: heard.append((stage, done, total)),
            lambda: len(heard) > 2,
        ),
    )
    assert not report.complete
    assert {row["graphs"] for row in report.table} == {2}
    assert heard == [("graphs", k, 5) for k in range(3)]


def test_a_stop_before_the_first_graph_leaves_an_empty_report(tmp_path: Path) -> None:
    report = run_laws(graphs=1, nodes=60, progress=Progress(stop=lambda: True))
    assert not report.complete
    assert report.table == ()
    write_report(report, tmp_path)


def test_the_table_has_medians_and_maxima() -> None:
    runs = [replace(ideal(graph, CASES[0]), largest_input=float(graph)) for graph in range(3)]
    (row,) = law_table(runs)
    assert (row["largest_input"], row["largest_input_max"], row["graphs"], row["h"]) == (1.0, 2.0, 3, 1.0)


def test_no_graphs_are_refused() -> None:
    with pytest.raises(OptionError, match="at least 1"):
        run_laws(graphs=0)
    with pytest.raises(OptionError, match="seed"):
        run_laws(graphs=1, seed=-1)
