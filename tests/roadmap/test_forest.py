"""A forest numbers each configuration once and keeps its edges sorted."""

import numpy as np

from planner.roadmap.forest import Forest


def test_nodes_that_were_there_keep_their_numbers_and_new_ones_follow() -> None:
    there = np.array([[0.0, 1.0], [1.0, 0.0], [2.0, 2.0]])
    forest = Forest(there, np.array([[0, 1]]))
    forest.add_path(np.array([[1.0, 0.0], [5.0, 5.0], [2.0, 2.0]]))
    np.testing.assert_array_equal(forest.nodes(), [*there, [5.0, 5.0]])
    assert forest.edges().tolist() == [[0, 1], [1, 3], [2, 3]]
    assert all(q in forest for q in forest.nodes())
    assert np.array([1.0, 1.0]) not in forest
    assert len(forest) == 4


def test_one_by_one_and_by_an_index_the_same_nodes_are_found() -> None:
    rng = np.random.default_rng(0)
    there = rng.integers(0, 3, (400, 2)) + np.arange(400)[:, None] // 9  # many share their first joint's value
    there = np.unique(there, axis=0).astype(float)
    rows = np.concatenate([there[rng.permutation(len(there))[:70]], there[:30] + 0.5, there[:30] + 0.5])
    forest = Forest(there)
    numbers = [forest.add(q) for q in rows]
    assert numbers == [np.flatnonzero((forest.nodes() == q).all(axis=1))[0] for q in rows]
    np.testing.assert_array_equal(forest.nodes(), [*there, *there[:30] + 0.5])


def test_of_nodes_that_are_the_same_the_first_is_found_early_and_late() -> None:
    q = np.array([0.0, 1.0])
    forest = Forest(np.array([q, -q, q, -q]))
    assert forest.add(q) == 0
    for k in range(100):
        forest.add(np.array([k + 2.0, 0.0]))
    assert [forest.add(q), forest.add(-q)] == [0, 1]
    assert np.array([-0.0, 1.0]) not in forest  # a configuration is its bits


def test_many_edges_at_once_are_added_as_one_after_the_other() -> None:
    rng = np.random.default_rng(1)
    there, motions = rng.integers(0, 4, (40, 2)).astype(float), rng.integers(-1, 5, (300, 2, 2)).astype(float)
    one, other = Forest(there), Forest(there)
    for a, b in motions:
        one.add_edge(a, b)
    for some in np.split(motions, [0, 7, 100]):
        other.add_edges(some)
    np.testing.assert_array_equal(one.nodes(), other.nodes())
    np.testing.assert_array_equal(one.edges(), other.edges())
    empty = Forest()
    empty.add_edges(motions[:1])
    assert len(empty) == 2
