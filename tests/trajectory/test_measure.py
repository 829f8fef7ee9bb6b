"""Measurements along a path against independent ones: coal's distances, a dense look at every state."""

import itertools

import numpy as np
import pytest

from planner.collision.checker import is_free
from planner.trajectory.measure import joint_path_length, path_clearance, path_contact
from tests.worlds import checker_of, load, random_q


def test_the_first_contact_is_where_a_dense_look_finds_it() -> None:
    checker = checker_of("iiwa14", "paper")
    q = random_q(load("iiwa14"), 14)
    ends = q[[is_free(checker, each) for each in q]]
    hits = 0
    for a, b in itertools.pairwise(ends):
        found = path_contact(checker, np.array([a, b]))
        share = np.linspace(0, 1, 250)
        dense = [is_free(checker, a + s * (b - a)) for s in share]
        assert (found is None) == all(dense)
        if found is not None:
            hits += 1
            assert found.piece == 0
            assert found.s == pytest.approx(share[dense.index(False)], abs=6e-3)
            assert not is_free(checker, found.q)
    assert hits >= 3


def test_clearance_along_a_path_covers_both_ends() -> None:
    checker = checker_of("planar_2r", "window")
    path = np.array([[0.0, 0.1], [0.5, 0.1], [0.5, -0.4]])
    q, gaps = path_clearance(checker, path)
    np.testing.assert_array_equal(q[[0, -1]], path[[0, -1]])
    assert len(q) == len(gaps) > 50
    assert joint_path_length(path) == pytest.approx(1.0)
