"""The grid graphs of Section 4.3."""

from __future__ import annotations

import numpy as np
import pytest

from planner.reproduce.learning.graphs import GOAL, OFFSET, RANGE, START, GridGraph
from planner.reproduce.learning.threshold import second_cost
from tests.reproduce.learning.test_threshold import grid


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
    assert graph.shortest_length == pytest.approx(length[START, GOAL], rel=1e-12)
    assert (graph.shortest[0], graph.shortest[-1]) == (START, GOAL)
    assert graph.weights(graph.shortest).sum() == pytest.approx(graph.shortest_length, rel=1e-12)


def test_the_second_path_is_the_second_of_all_paths() -> None:
    graph = grid(3)
    # all paths up to 6 % longer than the shortest, by depth-first search that gives up where none is left
    left = np.array([dijkstra_from(graph, node) for node in range(36)])
    limit, found = 1.06 * graph.shortest_length, []

    def walk(node: int, been: tuple[int, ...], length: float) -> None:
        if node == GOAL:
            found.append(length)
            return
        for arc in range(int(graph.network.indptr[node]), int(graph.network.indptr[node + 1])):
            head = int(graph.network.indices[arc])
            if head not in been and length + graph.d[arc] + left[head] <= limit:
                walk(head, (*been, head), length + float(graph.d[arc]))

    walk(START, (START,), 0.0)
    assert len(found) >= 2
    assert sorted(found)[:2] == pytest.approx([graph.shortest_length, second_cost(graph, graph.d)], rel=1e-12)


def dijkstra_from(graph: GridGraph, node: int) -> float:
    from planner.reproduce.learning.graphs import distances

    return float(distances(graph.network, graph.d)[node])
