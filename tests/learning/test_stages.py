"""Planning stages against every path there is, training against the formula arc by arc."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner import gabf, learning
from planner.base.errors import AssumptionError
from planner.learning import ErrorDriven, Hebbian
from tests.learning.graphs import network_of, random_network, simple_paths
from tests.random_shapes import QUICK


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


def test_an_arc_learns_nothing_of_other_arcs_distances() -> None:
    network, d = random_network(1)
    stage = learning.planning_stage(network)
    elsewhere = np.where(np.arange(d.size) == 3, d, 0.5)
    for rule in (Hebbian(), ErrorDriven()):
        one, other = learning.trained(stage, rule, d), learning.trained(stage, rule, elsewhere)
        assert one.weight[3] == other.weight[3]


def test_training_some_arcs_leaves_the_others() -> None:
    network, d = random_network(2)
    stage = learning.planning_stage(network)
    some = learning.trained(stage, ErrorDriven(), d, np.array([1, 4]))
    every = learning.trained(stage, ErrorDriven(), d)
    assert some.weight[[1, 4]].tolist() == every.weight[[1, 4]].tolist()
    rest = np.setdiff1d(np.arange(network.n_arcs), [1, 4])
    assert (some.weight[rest] == learning.FIRST_WEIGHT).all()


def test_a_stage_starts_from_the_x_of_the_one_before_under_the_same_law() -> None:
    network, d = random_network(0)
    law = gabf.SingularityFree(T=0.5)
    first, second, third = learning.learn(network, ErrorDriven(), d, 2, law=law)
    assert (first.field.x0[1:] == learning.FIRST_STATE).all()
    assert second.field.x0.tolist() == first.field.x.tolist()
    assert third.field.x0.tolist() == second.field.x.tolist()
    for stage in (first, second, third):
        assert stage.field.law is law
        assert stage.field.settling_time is not None
        assert stage.field.settling_time < 0.5


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
    network = learning.untrained(network.tails, network.indices, network.sources, network.n_nodes, first)
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


def test_in_turn_each_arc_sees_what_the_ones_before_it_did() -> None:
    network = network_of([(0, 1), (1, 2)], 3)  # arcs (0, 1), (1, 0), (1, 2), (2, 1)
    d, rule = np.array([0.1, 0.1, 0.2, 0.2]), ErrorDriven(alpha=0.8, beta=1.0)
    last = learning.learn_in_turn(network, rule, d, iterations=1)[-1]
    w10 = 0.5 + 0.8 * 0.5 * (0.9 - 0.5)  # a_0 = 1, a_1 = 0.5
    w12 = 0.5 + 0.8 * w10 * (0.5 * w10) * (0.8 - 0.5)  # now a_1 = w10, a_2 = 0.5 w10
    assert last.wbar[1] == pytest.approx(w10)
    assert last.wbar[2:] == pytest.approx([w12, w12])
    at_once = learning.learn(network, rule, d, iterations=1)[-1]
    assert at_once.wbar[2] == pytest.approx(0.5 + 0.8 * 0.5 * 0.25 * (0.8 - 0.5))


def test_in_turn_and_at_once_end_at_the_same_weights() -> None:
    network, d = random_network(3)
    rule = ErrorDriven(alpha=50.0, beta=0.1)
    ends = [train(network, rule, d, 6)[-1].wbar for train in (learning.learn, learning.learn_in_turn)]
    assert ends[0] == pytest.approx(rule.target(d), rel=1e-14)
    assert ends[1] == pytest.approx(rule.target(d), rel=1e-14)


def test_nodes_without_a_path_are_silent() -> None:
    # node 2 reads node 1, node 3 reads nothing and is read by node 1
    network = learning.untrained(np.array([1, 1, 2]), np.array([0, 3, 1]), np.array([0]), 4)
    d = np.array([0.1, 0.1, 0.1])
    first, second = learning.learn(network, ErrorDriven(beta=0.1), d, 1)
    assert first.activity.tolist() == [1.0, 0.5, 0.25, 0.0]
    assert second.wbar[1] == learning.FIRST_WEIGHT
    assert second.wbar[0] > learning.FIRST_WEIGHT


def test_a_path_too_long_for_its_weights_is_refused_not_rounded_away() -> None:
    n = 60
    pairs = [(i, i + 1) for i in range(n - 1)]
    with pytest.raises(AssumptionError, match="progressive"):
        learning.planning_stage(network_of(pairs, n))
    network = network_of(pairs, n)
    nearer = learning.untrained(network.tails, network.indices, network.sources, network.n_nodes, 0.9)
    assert learning.planning_stage(nearer).activity[-1] == pytest.approx(0.9**59, rel=1e-9)
