"""Every method near the deadline, on a small graph: what each reaches, against the oracle."""

from __future__ import annotations

import numpy as np

from planner import gabf
from planner.reproduce.laws.cases import T_P
from planner.reproduce.laws.near_deadline import PRACTICAL_END, TRIALS, run_trials
from planner.reproduce.random_graphs import draw_graph


def test_errors_are_those_of_the_runs_themselves() -> None:
    graph = draw_graph(np.random.default_rng(0), 60)
    np.testing.assert_allclose(graph.x_star, gabf.oracle(graph.network), rtol=1e-12)
    found = list(run_trials(graph, 7))
    assert [(trial.case, trial.name) for trial, _ in found] == [(case, name) for case, name, _ in TRIALS]
    for trial, run in found:
        assert trial.graph == 7
        assert run.t[-1] <= T_P + 1e-12
        assert trial.best == run.error.min()
        assert trial.last == run.error[-1]
        assert trial.practical == run.error[run.t <= PRACTICAL_END + 1e-12][-1]
        assert trial.best <= min(trial.last, trial.practical)
    backward = [trial for trial, _ in found if "backward" in trial.name]
    assert all(trial.reached and trial.last < 1e-3 for trial in backward), "the implicit method gets there"
