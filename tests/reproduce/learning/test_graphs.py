"""The grid graphs of Section 4.3, and training in turn."""

import numpy as np
import pytest

from planner.gabf.learning import ErrorDriven, make_untrained_network, planning_stage
from reproduce.learning.graphs import GOAL, OFFSET, RANGE, START, GridGraph, draw_grid
from reproduce.learning.study import learn_in_turn


def grid(seed: int) -> GridGraph:
    return draw_grid(np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(5))
def test_a_graph_is_as_the_paper_describes_it(seed: int) -> None:
    graph = grid(seed)
    lattice = np.array([(x, y) for y in range(6) for x in range(6)]) / 5.0
    assert np.abs(graph.position - lattice).max() <= OFFSET
    distance = np.linalg.norm(graph.position[:, None] - graph.position[None], axis=2)
    linked = np.zeros((36, 36), dtype=bool)
    linked[graph.network.tails, graph.network.indices] = True
    assert (linked == ((distance <= RANGE) & ~np.eye(36, dtype=bool))).all()
    assert graph.d.tolist() == distance[graph.network.tails, graph.network.indices].tolist()
    assert (graph.network.weight == 0.5).all()
    corners = np.array([[0.0, 0.0], [1.0, 1.0]])
    assert np.linalg.norm(graph.position[:, None] - corners, axis=2).argmin(axis=0).tolist() == [START, GOAL]


@pytest.mark.parametrize("seed", range(3))
def test_the_shortest_path_is_the_one_that_floyd_and_warshall_find(seed: int) -> None:
    graph = grid(seed)
    length = np.full((36, 36), np.inf)
    length[graph.network.tails, graph.network.indices] = graph.d
    np.fill_diagonal(length, 0.0)
    for k in range(36):
        length = np.minimum(length, length[:, k : k + 1] + length[k])
    assert (graph.shortest[0], graph.shortest[-1]) == (START, GOAL)
    assert graph.length(graph.shortest) == pytest.approx(length[START, GOAL], rel=1e-12)
    assert graph.d[graph.network.arcs_along(graph.shortest)].sum() == pytest.approx(length[START, GOAL], rel=1e-12)


def test_in_turn_each_arc_sees_the_changes_of_the_ones_before_it() -> None:
    position = np.array([[0.0, 0.0], [0.1, 0.0], [0.3, 0.0]])
    arcs = np.array([[0, 1], [1, 0], [1, 2], [2, 1]])
    network, d = make_untrained_network(arcs[:, 0], arcs[:, 1], np.array([0]), 3), np.array([0.1, 0.1, 0.2, 0.2])
    rule = ErrorDriven(alpha=0.8, beta=1.0)
    last = learn_in_turn(planning_stage(network), rule, GridGraph(position, network, d, 0), 1, np.arange(4))[-1]
    w10 = 0.5 + 0.8 * 0.5 * (0.9 - 0.5)  # a_0 = 1, a_1 = 0.5
    w12 = 0.5 + 0.8 * w10 * (0.5 * w10) * (0.8 - 0.5)  # now a_1 = w10, a_2 = 0.5 w10
    assert last.wbar[1:] == pytest.approx([w10, w12, w12])
