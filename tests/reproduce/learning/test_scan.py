"""The scan of parameters: every pair for both rules, on graphs of its own, as far as it came."""

from __future__ import annotations

import numpy as np
import pytest

from planner import learning
from planner.base.progress import QUIET, Progress
from planner.learning import ErrorDriven
from planner.reproduce.learning import scan as module
from planner.reproduce.learning.graphs import START, draw_grid
from planner.reproduce.learning.scan import scan


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ALPHAS", (5.0,))
    monkeypatch.setattr(module, "BETAS", (0.001, 3.0))
    monkeypatch.setattr(module, "GRAPHS", 2)


def test_shares_are_those_of_training_each_graph_alone() -> None:
    found = scan(2, 3, QUIET)
    assert [(tried.rule.name, tried.rule.beta) for tried in found[2:]] == [
        (ErrorDriven().name, 0.001),
        (ErrorDriven().name, 3.0),
    ]
    graphs = [draw_grid(np.random.default_rng([3, 1, k])) for k in range(2)]
    right = [
        [
            np.array_equal(stage.path(START), graph.shortest)
            for stage in learning.learn(graph.network, ErrorDriven(alpha=5.0, beta=0.001), graph.d, 2)[1:]
        ]
        for graph in graphs
    ]
    assert found[2].share == tuple(np.mean(right, axis=0))
    assert found[2].last == found[2].share[-1]


def test_a_stop_keeps_what_was_tried() -> None:
    heard: list[int] = []
    progress = Progress(lambda stage, done, total: heard.append(done), lambda: len(heard) >= 1)
    assert len(scan(1, 0, progress)) == 1
