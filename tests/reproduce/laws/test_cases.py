"""The laws that are compared."""

from __future__ import annotations

import numpy as np
import pytest

from planner import gabf
from reproduce.laws import cases
from reproduce.laws.cases import CASES, FREE, PRESCRIBED
from reproduce.laws.graphs import draw_graph


def test_the_cases_are_those_of_the_paper() -> None:
    assert len(PRESCRIBED) == 4
    assert len(FREE) == 2 * 16
    assert {case.law.T for case in CASES} == {4.0}
    assert [case.label() for case in PRESCRIBED] == ["h = 1", "h = 2", "h = 4", "h = 8"]
    assert FREE[0].label() == "p1/p2 = 3/5, m1/m2 = 9/7"


@pytest.mark.parametrize("case", [PRESCRIBED[0], FREE[3], FREE[12], FREE[16], FREE[31]], ids=lambda case: case.label())
def test_inputs_and_settling_times_are_converged_to_one_per_cent(case, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = draw_graph(np.random.default_rng(0), nodes=150)
    optimum = gabf.structure(graph.network)
    measured, _ = cases.run_case(graph, optimum, case)
    monkeypatch.setattr(cases, "SOLVER", gabf.Splitting(tolerance=2e-5))
    converged, _ = cases.run_case(graph, optimum, case)
    for name in ("largest_input", "typical_input", "node_input", "settling_tau"):
        assert getattr(measured, name) == pytest.approx(getattr(converged, name), rel=0.01), name
