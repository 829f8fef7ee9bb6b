"""Pairs of runs that differ in one parameter."""

from __future__ import annotations

from dataclasses import replace

from planner.reproduce.laws.cases import FREE, PRESCRIBED
from planner.reproduce.laws.verdicts import EFFORTS, neighbours
from tests.reproduce.laws.test_verdicts import GRAPHS, ideal_runs, judged


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


def test_each_reading_of_effort_is_judged_by_itself() -> None:
    runs = [replace(run, energy=-run.energy) for run in ideal_runs()]
    for sentence, verdict in judged(runs).items():
        if "control effort" in sentence:
            assert verdict.confirmed == (0 if "energy" in sentence else GRAPHS)
    assert len(EFFORTS) == 4
