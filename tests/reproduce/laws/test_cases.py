"""The laws that are compared."""

import numpy as np
import pytest

from planner import gabf
from reproduce.laws import cases
from reproduce.laws.cases import FREE, PRESCRIBED
from reproduce.laws.graphs import draw_graph


@pytest.mark.parametrize("case", [PRESCRIBED[0], FREE[3], FREE[12], FREE[16], FREE[31]], ids=lambda case: case.label())
def test_inputs_and_settling_times_are_converged_to_one_per_cent(case, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = draw_graph(np.random.default_rng(0), nodes=150)
    optimum = gabf.structure(graph.network)
    measured, _ = cases.run_case(graph, optimum, case)
    monkeypatch.setattr(cases, "SOLVER", gabf.Splitting(tolerance=2e-5))
    converged, _ = cases.run_case(graph, optimum, case)
    for name in ("largest_input", "typical_input", "node_input", "settling_tau"):
        assert getattr(measured, name) == pytest.approx(getattr(converged, name), rel=0.01), name
