"""How large K must be, against every path there is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import OptionError
from planner.learning import K_for_excess, excess_bound, log_cost, sufficient_K
from tests.learning.graphs import random_network, simple_paths
from tests.random_shapes import QUICK


def ranked(seed: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Distances of a random network, and the weights of every path from its last node, shortest first."""
    network, d = random_network(seed)
    paths = [d[list(arcs)] for arcs in simple_paths(network, network.n_nodes - 1)]
    return d, sorted(paths, key=lambda weights: weights.sum())


def products(paths: list[np.ndarray], K: float) -> list[float]:
    return [float(np.prod(1.0 - weights / K)) for weights in paths]


@pytest.mark.parametrize("seed", range(30))
def test_from_the_sufficient_K_on_the_largest_product_is_that_of_the_shortest_path(seed: int) -> None:
    d, paths = ranked(seed)
    if len(paths) == 1:
        return
    K = sufficient_K(paths[0], paths[1].sum() - paths[0].sum(), d.max())
    assert d.max() <= K
    for factor in (1.0 + 1e-12, 1.01, 2.0, 10.0):
        assert int(np.argmax(products(paths, factor * K))) == 0


@pytest.mark.parametrize("seed", range(30))
def test_a_smaller_K_costs_no_more_than_the_excess_bound(seed: int) -> None:
    d, paths = ranked(seed)
    for factor in (1.001, 1.1, 2.0, 5.0):
        K = factor * d.max()
        taken = paths[int(np.argmax(products(paths, K)))]
        assert taken.sum() <= paths[0].sum() + excess_bound(paths[0], K)


def test_some_K_below_the_bound_does_go_wrong() -> None:
    # one arc of 1.0 against two of 0.55: the square of the long arc counts for more
    short, long = np.array([1.0]), np.array([0.55, 0.55])
    bound = sufficient_K(short, 0.1, 1.0)
    wrong = [K for K in np.linspace(1.001, bound, 200) if log_cost(long, K) < log_cost(short, K)]
    assert wrong
    assert max(wrong) < bound
    assert bound == pytest.approx(1.0 + 1.0 / 0.2)


@QUICK
@given(st.lists(st.floats(1e-3, 10.0), min_size=1, max_size=8), st.floats(1.01, 1e6))
def test_the_cost_lies_between_the_two_inequalities_of_the_proof(weights, factor) -> None:
    w = np.array(weights)
    K = factor * w.max()
    scaled = K * log_cost(w, K)
    assert w.sum() * (1.0 - 1e-12) <= scaled <= (w.sum() + excess_bound(w, K)) * (1.0 + 1e-12)


def test_K_for_excess_keeps_its_promise() -> None:
    rng = np.random.default_rng(0)
    for share in (0.1, 1e-3):
        for _ in range(20):
            w = rng.uniform(0.1, 2.0, rng.integers(1, 9))
            assert excess_bound(w, K_for_excess(2.0, share)) <= share * w.sum()


def test_without_a_gap_no_K_is_enough() -> None:
    assert sufficient_K(np.array([1.0, 2.0]), 0.0, 2.0) == np.inf
    assert sufficient_K(np.array([1.0, 2.0]), np.inf, 5.0) == 5.0


def test_bad_numbers_are_refused() -> None:
    with pytest.raises(OptionError, match="gap"):
        sufficient_K(np.array([1.0]), -0.1, 1.0)
    with pytest.raises(OptionError, match="K = 1"):
        log_cost(np.array([0.5, 1.0]), 1.0)
    with pytest.raises(OptionError, match="longest"):
        excess_bound(np.array([3.0]), 2.0)
    with pytest.raises(OptionError, match="share"):
        K_for_excess(1.0, 0.0)
