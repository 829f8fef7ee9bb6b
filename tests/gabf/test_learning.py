"""Learning rules against their formulae, planning stages against every path, training against the formula per arc."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner import gabf
from planner.gabf import learning
from planner.gabf.learning import ErrorDriven, Hebbian
from tests.random_shapes import QUICK

inside = st.floats(0.0, 1.0, exclude_min=True, exclude_max=True, allow_subnormal=False)
activity = st.floats(0.0, 1.0)
rate = st.floats(1e-6, 1e6)


def network_of(pairs: list[tuple[int, int]], n: int, source: int = 0) -> gabf.Network:
    """Both arcs of every pair, untrained."""
    arcs = np.array(sorted({*pairs, *((j, i) for i, j in pairs)}), dtype=np.int64).reshape(-1, 2)
    return learning.make_untrained_network(arcs[:, 0], arcs[:, 1], np.array([source]), n)


def random_network(seed: int, n: int = 7) -> tuple[gabf.Network, np.ndarray]:
    """A connected graph on points of the unit square, and its distances; node 0 is the source."""
    rng = np.random.default_rng(seed)
    points = rng.random((n, 2))
    tree = [(i, int(rng.integers(i))) for i in range(1, n)]
    more = [(i, j) for i in range(n) for j in range(i) if rng.random() < 0.5]
    network = network_of([*tree, *more], n)
    return network, np.linalg.norm(points[network.tails] - points[network.indices], axis=1)


def simple_paths(network: gabf.Network, node: int, been: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    """The arc ids of every path from ``node`` to a source that visits no node twice."""
    if node in network.sources:
        yield ()
        return
    for arc in range(int(network.indptr[node]), int(network.indptr[node + 1])):
        head = int(network.indices[arc])
        if head not in been and head != node:
            for rest in simple_paths(network, head, (*been, node)):
                yield (arc, *rest)


def test_the_hebbian_rule_is_the_printed_one() -> None:
    rng = np.random.default_rng(0)
    wbar, a, b, d = rng.uniform(0.3, 0.6, 9), rng.random(9), rng.random(9), rng.uniform(0.1, 0.3, 9)
    changed = Hebbian(alpha=0.2, beta=2.0).update(wbar, a, b, d)
    for k in range(9):
        assert changed[k] == pytest.approx(wbar[k] + 0.2 * a[k] * b[k] * (1.0 - 2.0 * d[k]), rel=1e-14)


def test_the_error_driven_rule_moves_by_its_gain_towards_its_fixed_point() -> None:
    rule = ErrorDriven(alpha=2.0, beta=0.5)
    wbar, d = np.array([0.5, 0.5, 0.95]), np.array([0.2, 0.2, 0.2])
    a, b = np.array([0.5, 1.0, 0.1]), np.array([0.5, 0.9, 0.2])
    # gains 0.5, 1 (1.8 capped) and 0.04; all weights go to 1 - 0.5 * 0.2 = 0.9
    assert rule.update(wbar, a, b, d) == pytest.approx([0.7, 0.9, 0.95 - 0.04 * 0.05], rel=1e-14)
    assert rule.target(d) == pytest.approx([0.9, 0.9, 0.9])


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rule", [Hebbian(), ErrorDriven()], ids=lambda rule: rule.name)
def test_activities_are_the_largest_products_of_weights(seed: int, rule: learning.LearningRule) -> None:
    network, d = random_network(seed)
    for stage in learning.learn(network, rule, d, iterations=3):
        for node in range(1, network.n_nodes):
            products = [stage.wbar[list(arcs)].prod() for arcs in simple_paths(network, node)]
            assert stage.activity[node] == pytest.approx(max(products), rel=1e-12)
        path = stage.path(network.n_nodes - 1)
        arcs = [int(network.arcs_between(i, j)[0]) for i, j in itertools.pairwise(path.tolist())]
        assert stage.wbar[arcs].prod() == pytest.approx(stage.activity[path[0]], rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_all_arcs_are_trained_at_once_each_by_its_own_ends(seed: int) -> None:
    network, d = random_network(seed)
    rule = ErrorDriven(alpha=1.5, beta=0.3)
    before, after = learning.learn(network, rule, d, iterations=1)
    a = [max(np.prod([0.5] * len(arcs)) for arcs in simple_paths(network, node)) for node in range(network.n_nodes)]
    for arc in range(network.n_arcs):
        i, j = int(network.tails[arc]), int(network.indices[arc])
        gain = min(1.0, 1.5 * a[i] * a[j])
        assert after.wbar[arc] == pytest.approx(0.5 + gain * (1.0 - 0.3 * d[arc] - 0.5), rel=1e-12)
    assert (before.iteration, after.iteration) == (0, 1)
    assert (before.wbar == learning.FIRST_WEIGHT).all()


@QUICK
@given(
    seed=st.integers(0, 50),
    alpha=st.floats(1e-3, 100.0),
    beta=st.floats(1e-6, 0.7),
    first=st.floats(0.01, 0.99),
    hebbian=st.booleans(),
)
def test_weights_stay_in_the_open_interval_and_the_kernel_progressive(seed, alpha, beta, first, hebbian) -> None:
    network, d = random_network(seed, 5)
    network = learning.make_untrained_network(network.tails, network.indices, network.sources, network.n_nodes, first)
    rule = Hebbian(alpha=alpha, beta=beta) if hebbian else ErrorDriven(alpha=alpha, beta=beta)
    for stage in learning.learn(network, rule, d, iterations=3):
        premises = stage.field.premises
        assert ((stage.wbar > 0.0) & (stage.wbar < 1.0)).all()
        assert stage.field.outcome is gabf.Ending.SETTLED
        assert premises.upper < 1.0
        # the zeta that the docstring of Stage proves, up to the rounding of 1 - a where a is near 1
        assert premises.zeta >= (1.0 - premises.upper) * (1.0 - stage.wbar.max()) * 0.999 - 1e-16
        assert premises.zeta > 0.0
        assert premises.L < 1.0


def test_nodes_without_a_path_are_silent() -> None:
    # node 2 reads node 1, node 3 reads nothing and is read by node 1
    network = learning.make_untrained_network(np.array([1, 1, 2]), np.array([0, 3, 1]), np.array([0]), 4)
    d = np.array([0.1, 0.1, 0.1])
    first, second = learning.learn(network, ErrorDriven(beta=0.1), d, 1)
    assert first.activity.tolist() == [1.0, 0.5, 0.25, 0.0]
    assert second.wbar[1] == learning.FIRST_WEIGHT
    assert second.wbar[0] > learning.FIRST_WEIGHT
