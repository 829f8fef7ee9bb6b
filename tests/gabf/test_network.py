import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from planner import gabf
from planner.gabf import AssumptionError

from .networks import Network, from_arcs, solve


def test_arrays_are_copied_and_read_only():
    weight = np.array([1.0, 2.0])
    net = Network([0, 0, 1, 2], [0, 1], weight, sources=[0], kernel=gabf.Additive())
    weight[0] = 9.0
    assert net.weight[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        net.weight[0] = 3.0


def test_arcs_along_are_those_between_node_after_node():
    net = Network([0, 1, 4, 6], [2, 2, 0, 0, 1, 0], np.arange(1.0, 7.0), sources=[0], kernel=gabf.Additive())
    for nodes in ([2, 1, 0, 2], [1, 0], [1], []):
        steps = [net.arcs_between(i, j)[0] for i, j in itertools.pairwise(nodes)]
        assert net.arcs_along(np.array(nodes, dtype=int)).tolist() == steps
    with pytest.raises(AssumptionError, match="node 0 does not read node 1"):
        net.arcs_along(np.array([1, 0, 1]))
    with pytest.raises(AssumptionError, match=r"nodes\[1\] must be a whole number from 0 to 2, got 3"):
        net.arcs_along(np.array([1, 3]))


def test_without_arcs_drops_them_and_their_costs():
    net = from_arcs(3, [(1, 0, 1.0), (1, 0, 2.0), (2, 1, 3.0)], arc_cost=[5.0, 6.0, 7.0])
    less = net.without_arcs(net.arcs_between(1, 0)[:1])
    assert less.weight.tolist() == [2.0, 3.0]
    assert less.arc_cost.tolist() == [6.0, 7.0]
    assert gabf.oracle(less).tolist() == [0.0, 2.0, 5.0]
    assert net.n_arcs == 3


def test_one_node_graph():
    net = Network([0, 0], [], [], sources=[0], source_values=[3.0], kernel=gabf.Additive())
    result = solve(net)
    assert result.x.tolist() == [3.0]
    assert result.outcome is gabf.Ending.SETTLED
    assert gabf.extract_path(net, result, 0).tolist() == [0]
    assert gabf.certify(net, result.law, result) == []


@settings(max_examples=100, deadline=None)
@given(st.integers(1, 30), st.floats(0.0, 0.5), st.integers(0, 10_000), st.sampled_from(["csr", "csc", "coo", "lil"]))
def test_a_scipy_graph_is_the_network_whose_field_is_scipys_distance_to_the_sources(n, density, seed, kind):
    """Along arcs i -> j of the adjacency matrix; directed, so a transpose too many would show."""
    rng = np.random.default_rng(seed)
    dense = rng.uniform(0.1, 5.0, (n, n)) * (rng.random((n, n)) < density)
    np.fill_diagonal(dense, 0.0)
    sources = np.unique(rng.integers(0, n, 2))
    graph = coo_array(dense).asformat(kind)
    net = gabf.Network.from_scipy(graph, sources)
    to_sources = dijkstra(graph.tocsr().T, indices=sources, min_only=True)
    np.testing.assert_allclose(gabf.oracle(net), to_sources, rtol=1e-13)
    np.testing.assert_allclose(solve(net).x, to_sources, rtol=1e-13)
    back = net.to_scipy()
    assert isinstance(back, csr_array)
    assert np.array_equal(back.toarray(), dense)
    assert np.array_equal(back.data, net.weight)
    np.testing.assert_allclose(dijkstra(back.T, indices=sources, min_only=True), to_sources, rtol=1e-13)
