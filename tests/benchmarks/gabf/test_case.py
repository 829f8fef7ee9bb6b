"""One measurement of the dynamics."""

from __future__ import annotations

import numpy as np

from benchmarks.gabf.case import KERNEL, geometric_network, measure
from benchmarks.memory import peak_memory


def test_the_network_is_linked_in_both_directions() -> None:
    network = geometric_network(200, 8, np.random.default_rng(0))
    assert network.kernel == KERNEL
    assert 8.0 <= network.n_arcs / network.n_nodes <= 11.0
    pairs = set(zip(network.tails.tolist(), network.indices.tolist(), strict=True))
    assert all((j, i) in pairs for i, j in pairs)


def test_measuring_counts_memory_and_every_run() -> None:
    found = measure(geometric_network(80, 6, np.random.default_rng(1)), repeats=2, rk45_repeats=1)
    repeats = {timing["method"]: timing["repeats"] for timing in found["timings"]}
    assert repeats == {"dijkstra": 2, "gabf": 2, "rk45 in tau": 1, "rk45 in t": 1}
    assert found["settled"]
    assert 1.0 < peak_memory() < 1e6
