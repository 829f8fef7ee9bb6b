"""Costs and the network of eq. (finew), against a dictionary written out by hand."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from planner import gabf
from planner.cost.scale import COSTS, manipulability_cost
from planner.kinematics.manipulability import manipulability
from planner.problem.options import CostIntegration, Metric
from planner.problem.request import Objective
from planner.roadmap.build import build_roadmap
from planner.roadmap.measure import measure_edges
from planner.search.network import build_network, distance_cost
from tests.worlds import load, make_post, post_roadmap


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
    assert net.source_values is not None
    assert net.source_values.tolist() == [0.0]
    # eq. (finew): f_i(x_j, w_ij) = x_j + (1 - beta) omega(j) + beta w_ij
    x = np.random.default_rng(0).random(net.n_nodes)
    x[roadmap.goals] = 0.0
    best = gabf.bellman_operator(net, x)
    for i in range(net.n_nodes):
        ways = [x[j] + (1 - beta) * omega[j] + beta * w for (a, j), w in expected.items() if a == i]
        assert best[i] == (0.0 if i in roadmap.goals else pytest.approx(min(ways)))


def test_the_edge_charge_does_not_mind_where_nodes_lie() -> None:
    """With the integral over edges a straight path costs the same in one edge or two; with node costs it does not."""
    robot, checker = load("planar_2r"), make_post()
    ends, middle = np.array([[0.5, 0.6], [0.9, 1.4]]), np.array([[0.7, 1.0]])
    costs = {}
    for cost_integration in get_args(CostIntegration):
        for nodes in (ends, np.vstack([ends[:1], middle, ends[1:]])):
            n = len(nodes)
            edges = np.column_stack([np.arange(n - 1), np.arange(1, n)])
            base = build_roadmap(robot, checker, ends[0], ends[1], nodes=10)
            made = replace(
                base,
                nodes=nodes,
                edges=edges,
                starts=[0],
                goals=[n - 1],
                proven=np.ones(n - 1),
                clearance=np.ones(n - 1),
                samples=np.ones(n - 1),
                manipulability=manipulability(robot, nodes),
                **measure_edges(robot, nodes, edges, base.scale),
            )
            network = build_network(made, Objective(0.0, cost_integration=cost_integration))
            costs[cost_integration, n] = gabf.oracle(network)[0]
    assert costs["edges", 2] == pytest.approx(costs["edges", 3], rel=1e-3)
    assert costs["nodes", 2] != pytest.approx(costs["nodes", 3], rel=0.1)
