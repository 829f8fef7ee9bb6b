"""One field, many starts: every path costs what Dijkstra says, and what x at its start says."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner import gabf
from planner.cost.scale import manipulability_cost
from planner.gabf.path import paths_from
from planner.problem.request import Objective
from planner.roadmap.connect_endpoints import attach
from planner.search.network import build_network, distance_cost, path_cost
from tests.worlds import make_post, post_roadmap

STARTS = np.array([[-0.9, 1.2], [-1.0, 0.8], [0.4, 2.2], [2.0, 1.0], [-2.4, -0.7], [0.9, 0.1]])
GOALS = np.array([[1.0, -0.8], [1.6, 0.6]])
BETA = 0.4


@pytest.fixture(scope="module")
def many():
    """A kept roadmap with six starts and two goals, and the one field of it."""
    roadmap = attach(post_roadmap(seed=1), make_post(), STARTS, GOALS)
    network = build_network(roadmap, Objective(BETA, cost_integration="nodes"))
    return roadmap, network, gabf.solve(network, law=gabf.SingularityFree(T=4.0))


def cheapest_by_dijkstra(roadmap) -> np.ndarray:
    """(s,) SciPy's answer, from the arrays alone."""
    omega = manipulability_cost(roadmap.manipulability, roadmap.scale)
    n, (i, j), weight = len(roadmap.nodes), roadmap.edges.T, distance_cost(roadmap)
    cost = np.concatenate([(1 - BETA) * omega[j] + BETA * weight, (1 - BETA) * omega[i] + BETA * weight])
    graph = csr_matrix((cost, (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n))
    return dijkstra(graph, indices=roadmap.starts)[:, roadmap.goals].min(axis=1)


def test_every_start_has_its_cheapest_path(many):
    roadmap, network, field = many
    paths = paths_from(network, field, roadmap.starts)
    best = cheapest_by_dijkstra(roadmap)
    assert len(paths) == len(STARTS)
    for start, path, cost in zip(roadmap.starts, paths, best, strict=True):
        assert path[0] == start
        assert path[-1] in roadmap.goals
        assert path_cost(network, path).total == pytest.approx(cost, rel=1e-12)
        assert field.x[start] == pytest.approx(cost, rel=1e-12)
        assert all(roadmap.edge_index(a, b) >= 0 for a, b in itertools.pairwise(path))
    assert len({int(path[-1]) for path in paths}) == 2  # each goal is somebody's nearest


def test_a_start_without_a_way_has_an_empty_path(many):
    roadmap, _, _ = many
    lonely = roadmap.part(np.ones(len(roadmap.nodes), dtype=bool), (roadmap.edges != roadmap.starts[2]).all(axis=1))
    network = build_network(lonely, Objective(BETA, cost_integration="nodes"))
    paths = paths_from(network, gabf.solve(network, law=gabf.SingularityFree(T=4.0)), lonely.starts)
    assert [len(path) > 0 for path in paths] == [True, True, False, True, True, True]
