"""A new roadmap: its density, its progress, what it refuses."""

import numpy as np
import pytest

from planner.base.errors import OptionError
from planner.roadmap.build import build_roadmap
from tests.roadmap.test_grow import A, B
from tests.worlds import checker_of, load


def test_build_roadmap_has_the_papers_density(post):
    roadmap = build_roadmap(load("planar_2r"), post, A[0], B[0], nodes=60)
    assert len(roadmap.nodes) == 60
    assert len(roadmap.edges) == round(60 * 2029 / 1012)
    assert roadmap.proven.all()
    assert roadmap.is_connected
    assert (np.lexsort((roadmap.edges[:, 1], roadmap.edges[:, 0])) == np.arange(len(roadmap.edges))).all()


def test_one_node_is_no_roadmap():
    with pytest.raises(OptionError, match="nodes must be greater than or equal to 2, got 1"):
        build_roadmap(load("planar_2r"), checker_of("planar_2r"), A[0], B[0], nodes=1)
