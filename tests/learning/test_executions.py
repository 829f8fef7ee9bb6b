"""Learning costs by paying them, on graphs small enough to know the answer."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from planner import gabf, learning
from planner.learning import ErrorDriven, run_executions
from planner.learning.executions import believed, policy_cost, touching
from tests.learning.graphs import network_of, random_network, simple_paths

RULE = ErrorDriven(beta=1e-4)


def optimum(network: gabf.Network, costs: np.ndarray, node: int) -> float:
    return min(costs[list(arcs)].sum() for arcs in simple_paths(network, node))


def detour() -> tuple[gabf.Network, np.ndarray]:
    """Node 3 reaches node 0 by node 1 at a cost of 10, or by node 2 at 4; between 1 and 2 there is nothing."""
    network = network_of([(0, 1), (1, 3), (0, 2), (2, 3)], 4)
    ways = {(0, 1): 5.0, (1, 3): 5.0, (0, 2): 2.0, (2, 3): 2.0}
    ends = zip(network.tails.tolist(), network.indices.tolist(), strict=True)
    return network, np.array([ways[min(i, j), max(i, j)] for i, j in ends])


def test_the_neighbours_of_a_path_are_seen_and_trained_and_no_others() -> None:
    network = network_of([(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 0)], 6)
    costs = np.full(network.n_arcs, 2.0)
    beliefs = believed(network, RULE, np.full(network.n_arcs, 1.0))
    first, second = itertools.islice(run_executions(beliefs, costs, RULE, [1, 1]), 2)
    assert first.path.tolist() == [1, 0]
    seen = {tuple(sorted(pair)) for pair in np.column_stack([network.tails, network.indices])[first.seen].tolist()}
    assert seen == {(0, 1), (1, 2), (0, 5)}
    changed = np.flatnonzero(second.stage.wbar != first.stage.wbar)
    assert changed.tolist() == first.seen.tolist() == touching(network, first.path).tolist()
    assert second.stage.wbar[changed] == pytest.approx(RULE.target(costs[changed]), rel=1e-15)


def test_both_ends_of_an_arc_need_not_be_visited_for_it_to_be_seen() -> None:
    network, costs = detour()
    # node 1 looks best at first; the other way begins and ends on the path taken, so its arcs are seen and learned
    beliefs = believed(network, RULE, np.where(costs == 5.0, 0.5, 0.6))
    assert [done.cost for done in run_executions(beliefs, costs, RULE, [3] * 3)] == [10.0, 4.0, 4.0]


def test_optimism_tries_what_pessimism_never_looks_at() -> None:
    # as the detour, with one more node on the cheap path: its middle arc is beside no node of the costly path
    network = network_of([(0, 1), (1, 4), (0, 2), (2, 3), (3, 4)], 5)
    costly = np.isin(network.tails, [1]) | np.isin(network.indices, [1])
    costs = np.where(costly, 5.0, 1.0)
    for name, far, expected in (("optimistic", 0.5, [10.0, 3.0, 3.0]), ("pessimistic", 30.0, [10.0, 10.0, 10.0])):
        beliefs = believed(network, RULE, np.where(costly, 0.1 if name == "optimistic" else 20.0, far))
        paid = [done.cost for done in run_executions(beliefs, costs, RULE, [4] * 3)]
        assert paid == expected, name


@pytest.mark.parametrize("seed", range(8))
def test_optimistic_executions_are_dear_at_most_n_over_2_times(seed: int) -> None:
    network, d = random_network(seed, 8)
    rng = np.random.default_rng(seed)
    edge = {pair: rng.uniform(1.0, 6.0) for pair in itertools.combinations(range(8), 2)}
    ends = zip(network.tails.tolist(), network.indices.tolist(), strict=True)
    costs = d * np.array([edge[min(i, j), max(i, j)] for i, j in ends])
    beliefs = believed(network, RULE, d)
    starts = rng.integers(1, 8, 30).tolist()
    excess = []
    for done in run_executions(beliefs, costs, RULE, starts):
        assert (1.0 - done.stage.wbar <= RULE.beta * costs * (1.0 + 1e-9)).all(), "optimism is lost"
        excess.append(done.cost - optimum(network, costs, int(done.path[0])))
    assert min(excess) >= -1e-12
    assert sum(value > 1e-3 for value in excess) <= 4
    assert max(excess[-10:]) <= 1e-3


@pytest.mark.parametrize("seed", range(4))
def test_policy_cost_is_what_following_each_path_pays(seed: int) -> None:
    network, d = random_network(seed)
    stage = learning.planning_stage(believed(network, RULE, d))
    costs = np.random.default_rng(seed).uniform(0.5, 2.0, d.size)
    total = policy_cost(stage, costs)
    for node in range(network.n_nodes):
        assert total[node] == pytest.approx(learning.execute(stage, costs, node).cost, rel=1e-12)


def test_policy_cost_knows_nodes_without_a_path() -> None:
    network = learning.untrained(np.array([1, 1, 2]), np.array([0, 3, 1]), np.array([0]), 4)
    total = policy_cost(learning.planning_stage(network), np.array([2.0, 1.0, 4.0]))
    assert total.tolist() == [0.0, 2.0, 6.0, np.inf]


def test_nothing_new_leaves_the_stage_as_it_is() -> None:
    network, costs = detour()
    done = list(run_executions(believed(network, RULE, costs), costs, RULE, [3, 3]))
    assert done[0].stage is done[1].stage
