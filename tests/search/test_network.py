"""Costs and the network of eq. (finew), against a dictionary written out by hand."""

from typing import get_args

import numpy as np
import pytest

from planner import gabf
from planner.cost.scale import COSTS, manipulability_cost
from planner.problem.options import Metric
from planner.problem.request import Objective
from planner.search.network import build_network, distance_cost
from tests.worlds import post_roadmap


@pytest.mark.parametrize("beta", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("name", COSTS)
@pytest.mark.parametrize("metric", get_args(Metric))
def test_the_network_is_the_roadmap_both_ways(beta, name, metric):
    roadmap = post_roadmap()
    net = build_network(roadmap, Objective(beta, name, metric, "nodes"))
    omega = manipulability_cost(roadmap.manipulability, roadmap.scale, name)
    weight = distance_cost(roadmap, metric)
    expected = {}
    for (i, j), w in zip(roadmap.edges.tolist(), weight, strict=True):
        expected[i, j] = expected[j, i] = float(w)
    found = {}
    for i in range(net.n_nodes):
        for arc in range(net.indptr[i], net.indptr[i + 1]):
            assert (i, int(net.indices[arc])) not in found
            found[i, int(net.indices[arc])] = float(net.weight[arc])
    assert found == expected
    np.testing.assert_array_equal(net.node_cost, omega)
    np.testing.assert_array_equal(net.sources, roadmap.goals)
    assert net.source_values.tolist() == [0.0]
    # eq. (finew): f_i(x_j, w_ij) = x_j + (1 - beta) omega(j) + beta w_ij
    x = np.random.default_rng(0).random(net.n_nodes)
    x[roadmap.goals] = 0.0
    best = gabf.bellman_operator(net, x)
    for i in range(net.n_nodes):
        ways = [x[j] + (1 - beta) * omega[j] + beta * w for (a, j), w in expected.items() if a == i]
        assert best[i] == (0.0 if i in roadmap.goals else pytest.approx(min(ways)))
