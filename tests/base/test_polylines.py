"""Paths cut into equal parts."""

from __future__ import annotations

import itertools

import numpy as np

from planner.base.arrays import so_far
from planner.base.polylines import cut, lengths_along, parts_of


def test_no_part_is_longer_than_asked_and_there_is_none_too_many() -> None:
    assert parts_of(np.array([0.0, 0.9, 1.0, 1.01, 7.0]), 1.0).tolist() == [1, 1, 1, 2, 7]


def test_lengths_are_those_from_the_beginning() -> None:
    assert lengths_along(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]])).tolist() == [0.0, 5.0, 6.0]
    assert lengths_along(np.zeros((1, 3))).tolist() == [0.0]
    assert so_far(np.array([2, 0, 3])).tolist() == [0, 2, 2, 5]
    assert so_far(np.zeros(0, dtype=np.int64)).dtype == np.int64  # indices stay indices


def test_the_parts_are_equal_and_the_paths_own_rows_stay_to_the_bit() -> None:
    path = np.random.default_rng(0).normal(size=(5, 3)) / 3
    path[1], path[2] = -0.0, 1.0  # a zero keeps its sign: hashes tell them apart
    parts = np.array([1, 4, 2, 3])
    rows = cut(path, parts)
    first = np.concatenate([[0], np.cumsum(parts)])
    assert rows[first].tobytes() == path.tobytes()
    for k, (a, b) in enumerate(itertools.pairwise(path)):
        np.testing.assert_allclose(rows[first[k] : first[k + 1] + 1], np.linspace(a, b, parts[k] + 1), atol=1e-15)


def test_a_motion_past_pi_is_cut_along_itself() -> None:
    rows = cut(np.array([[3.0], [-3.0]]), np.array([2]), np.array([[2 * np.pi - 6.0]]))
    np.testing.assert_allclose(rows, [[3.0], [np.pi], [-3.0]], atol=1e-15)


def test_a_single_state_is_left_alone() -> None:
    assert cut(np.ones((1, 2)), np.zeros(0, dtype=np.int64)).tolist() == [[1.0, 1.0]]
