"""Hops to a source, against SciPy's breadth-first search; and the index arithmetic beneath."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner.gabf import reachability
from planner.gabf.reachability import arcs_reading, distinct, hops_to_source, ranges

from .networks import scattered


@pytest.mark.parametrize("sweep_below", [0, 10**9], ids=["reversed graph", "sweeps"])
@pytest.mark.parametrize("seed", range(3))
def test_hops_are_scipys(seed, sweep_below, monkeypatch):
    monkeypatch.setattr(reachability, "SWEEP_BELOW", sweep_below)
    net = scattered(80, seed=seed, degree=2)
    graph = csr_matrix((np.ones(net.n_arcs), net.indices, net.indptr), shape=(80, 80))
    far = dijkstra(graph, unweighted=True)[:, net.sources].min(axis=1)
    assert np.array_equal(hops_to_source(net), np.where(np.isfinite(far), far, -1))


def test_arcs_reading_are_those_with_that_head():
    net, nodes = scattered(50), np.array([3, 17])
    assert sorted(arcs_reading(net, nodes)) == np.flatnonzero(np.isin(net.indices, nodes)).tolist()


def test_ranges_and_distinct():
    assert ranges(np.array([5, 0, 9]), np.array([2, 0, 3])).tolist() == [5, 6, 9, 10, 11]
    for n in (10, 10_000):  # both branches
        assert distinct(np.array([7, 2, 7, 0]), n).tolist() == [0, 2, 7]
