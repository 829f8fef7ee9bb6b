"""The baseline is right itself: its repaired field is Dijkstra's after every change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.replan.lifelong import repair_field
from planner import gabf
from reproduce.laws.graphs import draw_graph


@pytest.mark.parametrize("seed", range(5))
def test_the_repaired_field_is_dijkstras(seed: int) -> None:
    rng = np.random.default_rng(seed)
    whole = draw_graph(rng, nodes=100, out_degree=6).network
    x = gabf.oracle(whole)
    for _ in range(10):
        few = rng.choice(whole.n_arcs, size=int(rng.integers(1, 60)), replace=False)
        weight = np.array(whole.weight)
        weight[few] *= np.exp(rng.uniform(-2, 2, few.size))
        net = replace(whole, weight=weight).without_arcs(few[::3])
        found = repair_field(net, x, start=int(rng.integers(100)))
        assert gabf.max_error(found.x, gabf.oracle(net)) <= 1e-12
        assert found.updates_to_start <= found.updates
        x = found.x


def test_nothing_changed_costs_nothing() -> None:
    net = draw_graph(np.random.default_rng(0), nodes=100, out_degree=6).network
    assert repair_field(net, gabf.oracle(net), 3).updates == 0
