"""OMPL's PRM as the benchmark asks it: as many nodes as asked for, free ones, and paths between their ends."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.roadmap.ompl_prm import OmplPrm
from planner.base.errors import OptionError
from planner.collision.checker import is_free
from tests.worlds import POST_GOAL, POST_START, load, make_post


def test_nodes_are_free_and_paths_lead_from_end_to_end() -> None:
    checker = make_post()
    prm = OmplPrm(load("planar_2r"), lambda q: is_free(checker, q), seed=0)
    prm.build(60)
    nodes, edges = prm.graph()
    assert 60 <= len(nodes) < 70
    assert all(is_free(checker, q) for q in nodes)
    assert (edges[:, 0] < edges[:, 1]).all()
    assert edges.max() < len(nodes)
    path = prm.query(POST_START, POST_GOAL)
    np.testing.assert_array_equal(path[[0, -1]], [POST_START, POST_GOAL])
    back = prm.query(POST_GOAL, POST_START)
    np.testing.assert_array_equal(back[[0, -1]], [POST_GOAL, POST_START])


def test_continuous_joints_are_left_out() -> None:
    with pytest.raises(OptionError, match="kinova has continuous joints"):
        OmplPrm(load("kinova"), lambda q: True, seed=0)
