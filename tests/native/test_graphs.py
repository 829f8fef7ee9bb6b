"""Cheapest paths and detours, against SciPy's Dijkstra."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner.native.compiled import cheapest_costs, detours
from planner.native.graphs import cheapest_nodes


def test_the_cheapest_path_is_dijkstras_over_directed_arcs() -> None:
    rng, n = np.random.default_rng(1), 60
    found = 0
    for _ in range(60):
        m = int(rng.integers(n, 3 * n))
        code = rng.choice(n * n, size=m, replace=False)
        arcs = np.column_stack([code // n, code % n])
        cost = np.where(rng.random(m) < 0.1, np.inf, rng.uniform(0.0, 1.0, m))
        starts, goals = rng.integers(0, n, 3), rng.integers(0, n, 2)
        path = cheapest_nodes(n, arcs, cost, starts, goals)
        usable = np.isfinite(cost)
        graph = csr_matrix((cost[usable], (arcs[usable, 1], arcs[usable, 0])), shape=(n, n))
        truth = dijkstra(graph, indices=goals, min_only=True)
        np.testing.assert_allclose(cheapest_costs(n, arcs, cost, goals, np.zeros(2)), truth, rtol=1e-12)
        least = truth[starts].min()
        if not len(path):
            assert np.isinf(least)
            continue
        price = {tuple(arc): c for arc, c in zip(arcs.tolist(), cost, strict=True)}
        assert path[0] in starts
        assert path[-1] in goals
        assert sum(price[i, j] for i, j in pairwise(path.tolist())) == pytest.approx(least, rel=1e-12)
        found += 1
    assert 20 < found < 60


def test_detours_are_dijkstras() -> None:
    rng = np.random.default_rng(0)
    for nodes, edges in ((2, 1), (30, 40), (200, 500)):
        ends = rng.integers(0, nodes, (edges, 2))
        ends = np.unique(np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1), axis=0)
        lengths = rng.uniform(0.1, 1.0, len(ends))
        graph = csr_matrix((lengths, ends.T), shape=(nodes, nodes))
        pairs = rng.integers(0, nodes, (300, 2))
        truth = dijkstra(graph, directed=False)[pairs[:, 0], pairs[:, 1]]
        np.testing.assert_allclose(detours(nodes, ends, lengths, pairs, np.full(300, np.inf)), truth, rtol=1e-12)
        limits = rng.uniform(0.0, 2.0, 300)
        capped = detours(nodes, ends, lengths, pairs, limits)
        np.testing.assert_allclose(capped, np.where(truth <= limits, truth, np.inf), rtol=1e-12)
