"""Links between neighbours, against brute force."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.roadmap.connections import candidate_links, connect, find_nearest, nearest_neighbours
from planner.roadmap.roadmap import component_labels
from tests.random_shapes import QUICK
from tests.worlds import load, random_q, scene_of


def nearest_by_tree(nodes, count) -> tuple[np.ndarray, np.ndarray]:
    """Distances and indices (n, count) by SciPy; each node's first is itself."""
    tree: Any = KDTree(nodes)
    found = tree.query(nodes, k=list(range(1, count + 2)))
    return found[0][:, 1:], found[1][:, 1:]


@pytest.mark.parametrize("n", [1, 2, 3, 30, 700])
def test_nearest_neighbours_are_a_kd_trees(n):
    robot = load("iiwa14")
    nodes = random_q(robot, n)
    order, length = nearest_neighbours(robot, nodes, 5)
    count = min(5, n - 1)
    distance, index = nearest_by_tree(nodes, count)
    np.testing.assert_allclose(length, distance, atol=1e-12)
    np.testing.assert_array_equal(order, index)


@pytest.mark.parametrize("n", [20, 60])
def test_nearest_neighbours_wrap(n):
    robot = load("kinova")
    nodes = random_q(robot, n, seed=1)
    order, length = nearest_neighbours(robot, nodes, 4)
    for i in range(n):
        apart = np.array([np.linalg.norm(robot.difference(nodes[i], nodes[j])) for j in range(n)])
        apart[i] = np.inf
        np.testing.assert_array_equal(order[i], np.argsort(apart)[:4])
        np.testing.assert_allclose(length[i], np.sort(apart)[:4])
    _, plain = nearest_by_tree(nodes, 4)
    assert (plain != order).any()


def test_candidates_are_every_near_pair_once_and_none_that_is_known():
    robot, nodes = load("iiwa14"), random_q(load("iiwa14"), 50, seed=2)
    _, index = nearest_by_tree(nodes, 6)
    known = np.array([[index[3, 0], 3], [20, index[20, 2]], [0, index[0, 5]]])
    pairs = candidate_links(robot, nodes, known, 6)
    taken = {(min(i, j), max(i, j)) for i, j in known.tolist()}
    near = {(min(i, int(j)), max(i, int(j))) for i in range(50) for j in index[i]}
    assert taken <= near
    assert len(pairs) == len({tuple(p) for p in pairs})
    assert {tuple(p) for p in pairs} == near - taken
    first = {(min(i, int(index[i, 0])), max(i, int(index[i, 0]))) for i in range(50)} - taken
    assert {tuple(p) for p in pairs[: len(first)]} == first


@pytest.fixture(scope="module")
def free_nodes(post):
    states = random_q(load("planar_2r"), 80, seed=3)
    return np.array([q for q in states if post.first_contact(q[None]) is None][:50])


@pytest.mark.parametrize("target", [10, 60, 100])
def test_connect_reaches_its_target_and_keeps_what_is_given(post, free_nodes, target):
    prover = EdgeProver(post)
    tree = np.array([[i, i + 1] for i in range(5)])
    given_free = prover.prove(free_nodes[tree[:, 0]], free_nodes[tree[:, 1]] - free_nodes[tree[:, 0]]).free
    tree = tree[given_free]
    edges = connect(prover, free_nodes, tree, target)
    assert len(edges) == target
    np.testing.assert_array_equal(edges[: len(tree)], tree)
    assert (edges[:, 0] < edges[:, 1]).all()
    assert len(np.unique(edges, axis=0)) == target
    delta = free_nodes[edges[:, 1]] - free_nodes[edges[:, 0]]
    assert prover.prove(free_nodes[edges[:, 0]], delta).free.all()
    np.testing.assert_array_equal(connect(prover, free_nodes, tree, target), edges)


@QUICK
@given(st.integers(1, 40), st.data())
def test_components_are_scipys(n, data):
    pairs = data.draw(st.lists(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)), max_size=60))
    edges = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    labels = component_labels(n, edges)
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    count, expected = connected_components(graph, directed=False)
    assert labels.max() + 1 == count
    assert (labels[:, None] == labels[None]).tolist() == (expected[:, None] == expected[None]).tolist()
    _, first = np.unique(labels, return_index=True)
    assert (np.diff(first) > 0).all()  # numbered in the order of the nodes


def test_the_nearest_to_angles_just_below_zero():
    """Rounding takes them to a whole turn, which SciPy's tree refuses."""
    robot = load("kinova")
    nodes = random_q(robot, 300)
    nodes[7, robot.continuous] = -4e-16
    length, order = find_nearest(robot, nodes, nodes, 1)
    assert order[7, 0] == 7
    assert length[7, 0] < 1e-12


def test_no_link_turns_by_half_a_turn():
    """Its ends do not tell which way round it goes."""
    robot = load("kinova")
    nodes = np.array([robot.home, robot.home])
    nodes[1, 5] += np.pi
    prover = EdgeProver(make_checker(robot, scene_of()))
    assert len(connect(prover, nodes, np.zeros((0, 2), dtype=np.int64), 1)) == 0
    nodes[1, 5] -= 0.1
    assert len(connect(prover, nodes, np.zeros((0, 2), dtype=np.int64), 1)) == 1
