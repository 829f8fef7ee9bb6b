"""The optimum by Dijkstra against SciPy and value iteration, and its structure."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner import gabf
from planner.gabf import certificates as bounds
from planner.gabf.oracle import _dijkstra
from planner.gabf.problem import reduce_network

from .networks import from_arcs, scattered


@pytest.mark.parametrize("values", [(0.0, 0.0), (0.3, 2.0)])
def test_the_heap_and_the_compiled_search_agree_to_the_bit(values):
    """With parallel arcs, unreachable nodes, a source that would be cheaper by another one, and scipy's opinion."""
    net = scattered(150, seed=3, kernel=gabf.Additive())
    doubled = np.repeat(np.arange(net.n_arcs), 2)
    weight = net.weight[doubled] * np.tile([1.0, 1.7], net.n_arcs)
    heads, tails = net.indices[doubled], net.tails[doubled]
    parallel = replace(
        gabf.Network.from_arcs(tails, heads, weight, np.array([0, 1]), 152, kernel=gabf.Additive()),
        source_values=values,
    )
    compiled = gabf.oracle(parallel)
    problem = reduce_network(parallel)
    assert np.array_equal(compiled, problem.unpack(_dijkstra(problem)))
    assert np.isinf(compiled[150:]).all()
    keep = (net.tails > 1) | (net.indices > 1)
    graph = csr_matrix((net.weight[keep], (net.indices[keep], net.tails[keep])), shape=(150, 150))
    away = [dijkstra(graph, indices=source) + value for source, value in enumerate(values)]
    np.testing.assert_allclose(compiled[2:150], np.minimum(*away)[2:], rtol=1e-13)
    assert tuple(compiled[:2]) == values


def test_max_error_is_relative_and_catches_disagreement_on_reachability():
    x_star = np.array([0.0, 0.5, 100.0, np.inf])
    assert gabf.max_error(np.array([0.0, 0.6, 101.0, np.inf]), x_star) == pytest.approx(0.1)
    assert gabf.max_error(np.array([0.0, 0.5, 101.0, np.inf]), x_star) == pytest.approx(0.01)
    assert gabf.max_error(np.array([0.0, 0.5, 100.0, 7.0]), x_star) == np.inf


def test_levels_are_the_distinct_values_and_longest_paths_follow_true_parents():
    net = scattered(90, seed=7)
    found = gabf.structure(net)
    rows = np.flatnonzero(found.longest > 0)
    assert np.unique(np.round(found.x_star[rows], 10)).size == found.R
    assert np.allclose(found.values[found.level[rows]], found.x_star[rows])
    for i in rows:
        parents = gabf.true_parents(net, found, int(i))
        assert parents.size
        assert found.longest[i] == 1 + found.longest[parents].max()
        assert found.fewest[i] == 1 + found.fewest[parents].min()
        assert (found.level[parents] < found.level[i]).all()
    assert found.diameter == found.longest.max() + 1


def test_paths_that_tie_up_to_rounding_count_as_ties():
    net = from_arcs(4, [(1, 0, 0.1), (2, 1, 0.2), (3, 2, 0.3), (3, 0, 0.6)])
    found = gabf.structure(net)
    assert 0.1 + 0.2 + 0.3 != 0.6
    assert gabf.true_parents(net, found, 3).tolist() == [0, 2]
    assert (found.longest[3], found.fewest[3]) == (3, 1)


@pytest.mark.parametrize(("far", "near"), [(1.0, 9e-13), (1e6, 9e-7), (0.5, 1e-15)])
def test_a_chain_of_tiny_arcs_has_as_many_levels_as_arcs(far, near):
    costs = [far] + [near] * 10
    found = gabf.structure(from_arcs(12, [(i + 1, i, cost) for i, cost in enumerate(costs)]))
    assert found.R == len(costs) == len(set(np.cumsum(costs)))
    assert found.level.tolist() == list(range(12))


def test_log_alpha_is_the_maximum_that_theorem_exponential_defines():
    for diameter in (2, 3, 4, 9, 50):
        k = np.arange(diameter - 1)
        alpha = [(i / (0.5 * np.e)) ** i for i in k]
        assert bounds.log_alpha(diameter) == pytest.approx(np.log(max(alpha)), abs=1e-12)
    assert np.isfinite(bounds.log_alpha(100_000))
