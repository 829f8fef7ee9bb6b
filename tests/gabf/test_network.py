import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array, csr_array, csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner import gabf
from planner.gabf import ArrayError, AssumptionError

from .networks import Network, from_arcs, solve


def test_arrays_are_copied_and_read_only():
    weight = np.array([1.0, 2.0])
    net = Network([0, 0, 1, 2], [0, 1], weight, sources=[0], kernel=gabf.Additive())
    weight[0] = 9.0
    assert net.weight[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        net.weight[0] = 3.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"indices": [0, 5]}, r"indices\[1\] is 5: give whole numbers from 0 to 2"),
        ({"indices": [0, 2]}, "node 2 reads itself"),
        ({"weight": [1.0, np.nan]}, r"weight\[1\] is nan"),
        ({"weight": [1.0, np.inf]}, r"weight\[1\] is inf"),
        ({"weight": [1.0]}, "weight"),
        ({"indptr": [0, 2, 1, 2]}, "indptr"),
        ({"indptr": [1, 1, 1, 2]}, "indptr"),
        ({"indices": [0.0, 1.5]}, "whole numbers"),
        ({"sources": []}, "at least one source"),
        ({"sources": [3]}, r"sources\[0\] is 3"),
        ({"sources": [0, 0]}, "each once"),
        ({"source_values": [0.0, 1.0]}, "source_values"),
        ({"node_cost": [1.0]}, "node_cost"),
        ({"arc_cost": [1.0, np.nan]}, r"arc_cost\[1\] is nan"),
    ],
)
def test_what_is_not_a_graph_is_refused(changes, message):
    given = {
        "indptr": [0, 0, 1, 2],
        "indices": [0, 1],
        "weight": [1.0, 2.0],
        "sources": [0],
        "kernel": gabf.Additive(),
    }
    with pytest.raises(AssumptionError, match=message):
        Network(**(given | changes))


def test_arcs_between_finds_parallel_arcs_in_one_direction():
    net = from_arcs(3, [(1, 0, 1.0), (1, 0, 2.0), (2, 1, 1.0)])
    assert net.arcs_between(1, 0).tolist() == [0, 1]
    assert net.arcs_between(0, 1).size == 0
    for i, j in ((1, 3), (1, -1), (3, 1)):
        with pytest.raises(AssumptionError, match="from 0 to 2"):
            net.arcs_between(i, j)
    for i in (-1, 3):
        with pytest.raises(ArrayError, match="from 0 to 2"):
            gabf.true_parents(net, gabf.structure(net), i)


def test_arcs_along_are_those_between_node_after_node():
    net = Network([0, 1, 4, 6], [2, 2, 0, 0, 1, 0], np.arange(1.0, 7.0), sources=[0], kernel=gabf.Additive())
    for nodes in ([2, 1, 0, 2], [1, 0], [1], []):
        steps = [net.arcs_between(i, j)[0] for i, j in itertools.pairwise(nodes)]
        assert net.arcs_along(np.array(nodes, dtype=int)).tolist() == steps
    with pytest.raises(AssumptionError, match="node 0 does not read node 1"):
        net.arcs_along(np.array([1, 0, 1]))
    with pytest.raises(AssumptionError, match=r"nodes\[1\] is 3: give whole numbers"):
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


def test_arcs_in_any_order_make_the_same_network() -> None:
    rng = np.random.default_rng(0)
    tails, heads = np.array([1, 2, 2, 3, 3]), np.array([0, 0, 1, 1, 2])
    weight, cost = rng.random(5), rng.random(5)
    kernel = gabf.Additive()
    plain = Network.from_arcs(tails, heads, weight, np.array([0]), 4, arc_cost=cost, kernel=kernel)
    np.testing.assert_array_equal(plain.indptr, [0, 0, 1, 3, 5])
    np.testing.assert_array_equal(plain.weight, weight)
    mixed = rng.permutation(5)
    other = Network.from_arcs(
        tails[mixed], heads[mixed], weight[mixed], np.array([0]), 4, arc_cost=cost[mixed], kernel=kernel
    )
    for name in ("indptr", "indices", "weight", "arc_cost", "tails"):
        np.testing.assert_array_equal(getattr(other, name), getattr(plain, name))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"heads": [0, 5, 1]}, r"heads\[1\] is 5"),
        ({"heads": [0, -1, 1]}, r"heads\[1\] is -1"),
        ({"tails": [1, 3, 2]}, r"tails\[1\] is 3"),
        ({"tails": [1.0, 2.5, 2.0]}, r"tails\[1\] is 2.5"),
        ({"heads": [0, 0]}, "heads"),
        ({"weight": np.ones(4)}, "weight"),
    ],
)
def test_a_list_of_arcs_that_is_none_is_refused(changes, message) -> None:
    arcs = {"tails": [1, 2, 2], "heads": [0, 0, 1], "weight": np.ones(3)} | changes
    with pytest.raises(AssumptionError, match=message):
        Network.from_arcs(**arcs, sources=[0], n_nodes=3, kernel=gabf.Additive())


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


def test_a_scipy_graph_follows_the_rules_of_a_network():
    stored = coo_array(([0.0, 2.0, 7.0], ([1, 2, 2], [0, 1, 1])), shape=(3, 3))
    net = gabf.Network.from_scipy(stored, [0])
    assert net.weight.tolist() == [0.0, 9.0]  # a stored zero is an arc, and SciPy adds duplicates up
    with pytest.raises(AssumptionError, match="not progressive"):
        solve(net)
    with pytest.raises(AssumptionError, match="would cost less"):
        gabf.oracle(gabf.Network.from_scipy(csr_array([[0, 0], [-1, 0]]), [0]))
    with pytest.raises(AssumptionError, match="node 1 reads itself"):
        gabf.Network.from_scipy(csr_array([[0.0, 0.0], [1.0, 1.0]]), [0])
    with pytest.raises(AssumptionError, match=r"a column per node, got shape \(3, 2\)"):
        gabf.Network.from_scipy(csr_matrix([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]), [0])
    with pytest.raises(TypeError, match=r"got ndarray: scipy.sparse.csr_array\(graph\) makes one"):
        gabf.Network.from_scipy(np.eye(2), [0])
    parallel = from_arcs(3, [(1, 0, 3.0), (1, 0, 2.0), (2, 1, 1.0)])
    assert dijkstra(parallel.to_scipy().T, indices=0).tolist() == [0.0, 2.0, 3.0] == gabf.oracle(parallel).tolist()
    costed = gabf.Network.from_scipy(parallel.to_scipy(), [0], node_cost=[0.5, 1.0, 1.0], kernel=gabf.TradeOff(0.0))
    assert solve(costed).x.tolist() == [0.0, 0.5, 1.5]
