"""OMPL's RRTConnect as the benchmark asks it: free paths from end to end, simplified ones, and none where none is."""

from __future__ import annotations

import numpy as np

from benchmarks.first_motion.ompl_connect import OmplConnect
from planner.base.arrays import Floats
from planner.collision.checker import is_free
from planner.paths.measure import joint_path_length
from tests.worlds import POST_GOAL, POST_START, load, make_post


def test_a_path_leads_from_end_to_end_through_states_that_were_found_free() -> None:
    checker, asked = make_post(), {}

    def looks_free(q: Floats) -> bool:
        return asked.setdefault(q.tobytes(), is_free(checker, q))

    connect = OmplConnect(load("planar_2r"), looks_free, seed=0)
    assert connect.solve(POST_START, POST_GOAL, seconds=30.0)
    path = connect.simplified()
    np.testing.assert_array_equal(path[[0, -1]], [POST_START, POST_GOAL])
    assert set(asked.values()) == {True, False}
    assert all(is_free(checker, q) for q in path)
    straight = float(np.linalg.norm(POST_GOAL - POST_START))
    assert straight < joint_path_length(path) < 4 * straight  # the post is in the straight way


def test_what_is_separated_has_no_path() -> None:
    connect = OmplConnect(load("planar_2r"), lambda q: abs(q[0]) > 0.5, seed=0)
    assert not connect.solve(np.array([-1.0, 0.0]), np.array([1.0, 0.0]), seconds=0.05)
