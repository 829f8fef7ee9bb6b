"""``planner reproduce laws``: the verdict logic on doctored measurements, and a small whole run."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.studies.laws import run as experiment
from planner.studies.laws.cases import CASES, FREE, PRESCRIBED, LawCase, Measurement
from planner.studies.laws.comparisons import EFFORTS, neighbours
from planner.studies.laws.fixed_time_bound import extreme_time, paper_times
from planner.studies.laws.near_deadline import ABOVE, BELOW, FIRST, TRIALS, Trial
from planner.studies.laws.remark_verdicts import bound_verdicts, remark_verdicts
from planner.studies.laws.run import law_table, run_laws
from planner.studies.laws.verdicts import GraphFacts, law_verdicts
from planner.studies.report import Report, Verdict, write_report

GRAPHS = 3


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


def facts(largest: float = 7.0) -> GraphFacts:
    return GraphFacts(500, 10.0, largest, 12, 0, 0, 11.0)


def judged(runs: list[Measurement], graphs: list[GraphFacts] | None = None) -> dict[str, Verdict]:
    verdicts = law_verdicts(graphs or [facts()] * GRAPHS, runs)
    assert len({verdict.sentence for verdict in verdicts}) == len(verdicts)
    return {verdict.sentence: verdict for verdict in verdicts}


def ideal_runs() -> list[Measurement]:
    return [ideal(graph, case) for graph in range(GRAPHS) for case in CASES]


def doctored(of_case, **changes) -> list[Measurement]:
    """The ideal runs with one graph's runs of the chosen cases changed."""
    return [replace(r, **changes) if r.graph == 1 and of_case(r.case) else r for r in ideal_runs()]


def test_the_cases_are_those_of_the_paper() -> None:
    assert len(PRESCRIBED) == 4
    assert len(FREE) == 2 * 16
    assert {case.law.T for case in CASES} == {4.0}
    assert [case.label for case in PRESCRIBED] == ["h = 1", "h = 2", "h = 4", "h = 8"]
    assert FREE[0].label == "p1/p2 = 3/5, m1/m2 = 9/7"


def test_ideal_measurements_confirm_every_sentence() -> None:
    for verdict in judged(ideal_runs()).values():
        assert verdict.holds, verdict
        assert verdict.of == GRAPHS


def test_neighbours_differ_in_one_parameter_of_one_graph() -> None:
    runs = [run for run in ideal_runs() if run.case in FREE]
    pairs = neighbours(runs, "p1/p2")
    assert len(pairs) == GRAPHS * 2 * 4 * 3
    for a, b in pairs:
        assert (a.graph, a.case.start, a.case.parameters["m1/m2"]) == (
            b.graph,
            b.case.start,
            b.case.parameters["m1/m2"],
        )
        assert a.case.law.p[0] + 2 == b.case.law.p[0]  # type: ignore[union-attr]
    assert len(neighbours([run for run in ideal_runs() if run.case in PRESCRIBED], "h")) == GRAPHS * 3


@pytest.mark.parametrize(
    ("broken", "changes", "sentence"),
    [
        (lambda c: c == PRESCRIBED[2], {"settling_time": 3.9}, "Larger h leads to faster"),
        (lambda c: c == PRESCRIBED[2], {"node_input": 1.0}, "... as the control effort increases (prescribed"),
        (lambda c: c == PRESCRIBED[0], {"settling_time": np.inf, "settling_tau": np.inf}, "All state errors converge"),
        (lambda c: c == PRESCRIBED[0], {"within_bounds": False}, "All the control inputs remain bounded (prescribed"),
        (lambda c: c == PRESCRIBED[0], {"largest_input": np.inf}, "All the control inputs remain bounded (prescribed"),
        (
            lambda c: c == FREE[5],
            {"settling_tau": 1.0},
            "Smaller p1/p2 yields faster convergence (singularity-free law, ",
        ),
        (
            lambda c: c == FREE[5],
            {"settling_tau": 1.0},
            "Smaller m1/m2 yields faster convergence (singularity-free law, ",
        ),
        (lambda c: c == FREE[5], {"error": 1e-3}, "The state error converges before"),
        (lambda c: c == FREE[5], {"last_input": 1.0}, "All the control inputs remain bounded (singularity-free"),
        (lambda c: c == FREE[5], {"largest_input": 1e6}, "(ours) No input grows beyond"),
        (lambda c: c == FREE[5], {"within_bounds": False}, "(ours) Every bound of the paper"),
    ],
)
def test_a_doctored_run_is_not_confirmed(broken, changes: dict, sentence: str) -> None:
    verdicts = judged(doctored(broken, **changes))
    hit = [verdict for text, verdict in verdicts.items() if text.startswith(sentence) and not verdict.holds]
    assert hit
    assert all(verdict.confirmed == GRAPHS - 1 for verdict in hit)


def test_each_reading_of_effort_is_judged_by_itself() -> None:
    runs = [replace(run, energy=-run.energy) for run in ideal_runs()]
    for sentence, verdict in judged(runs).items():
        if "control effort" in sentence:
            assert verdict.confirmed == (0 if "energy" in sentence else GRAPHS)
    assert len(EFFORTS) == 4


def test_a_start_below_is_no_overestimate() -> None:
    verdicts = judged(ideal_runs(), [facts(), facts(10.5), facts()])
    (verdict,) = (v for s, v in verdicts.items() if "overestimated" in s)
    assert (verdict.confirmed, verdict.of) == (2, 3)


def trials(**changes) -> list[Trial]:
    """Trials as remark (implementation) has them; ``changes`` by the first word of the method."""
    found = []
    for case, name, _ in TRIALS:
        last = 900.0 if name.startswith("forward") and case == ABOVE else 1e-5
        trial = Trial(0, case, name, 1e-6, last, 1e-5, not name.endswith("up to T_p"), 1000)
        found.append(replace(trial, **changes.get(name.split()[0].strip(",").lower(), {})))
    return found


def test_the_remark_is_confirmed_and_can_be_refuted() -> None:
    runs = [run for run in ideal_runs() if run.graph == 0]
    explicit, implicit, practical, above, below = remark_verdicts(trials(), runs)
    assert all(verdict.holds for verdict in (explicit, implicit, practical, above, below))
    explicit = remark_verdicts(trials(forward={"last": 1e-5}), runs)[0]
    implicit = remark_verdicts(trials(backward={"last": 2.0}), runs)[1]
    practical = remark_verdicts(trials(rk45={"practical": 0.5}), runs)[2]
    late = [replace(run, settling_time=3.99) if run.case.start == "below" else run for run in runs]
    assert [v.confirmed for v in (explicit, implicit, practical, *remark_verdicts(trials(), late)[3:])] == [
        0,
        0,
        0,
        1,
        0,
    ]
    assert {case for case, _, _ in TRIALS} == {ABOVE, BELOW, FIRST}


def test_the_printed_bound_fails_where_numerics_says() -> None:
    scalars = paper_times()
    by_label = {scalar.label: scalar for scalar in scalars}
    worst = by_label["3/5, 15/7"]
    assert worst.printed == pytest.approx(2.375)
    assert worst.measured == pytest.approx(2.799, abs=1e-3)
    printed, theorem, corrected, sharp = bound_verdicts(scalars, extreme_time())
    assert 0 < printed.confirmed < printed.of == 16
    assert "3/5, 15/7: 2.375 < 2.799" in printed.note
    assert not theorem.holds
    assert corrected.holds
    assert sharp.holds


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
    alone = experiment._study_graph(1, 60, 1, lambda n: None, QUIET)
    assert alone is not None
    rows = [row for row in small.more["runs"] if row["graph"] == 1]
    assert [row["settling_tau"] for row in rows] == [run.settling_tau for run in alone.runs]


def test_progress_is_told_and_a_stop_keeps_whole_graphs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experiment, "run_trials", lambda graph, k: iter(()))
    heard = []
    each = len(CASES) + len(TRIALS)
    report = run_laws(
        graphs=5,
        nodes=60,
        progress=Progress(
            lambda stage, done, total: heard.append((stage, done, total)),
            lambda: len(heard) > len(CASES) + 3,
        ),
    )
    assert not report.complete
    assert {row["graphs"] for row in report.table} == {1}
    assert heard[0] == ("runs", 1, 5 * each)
    assert heard[-1][1] == each + 4


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
