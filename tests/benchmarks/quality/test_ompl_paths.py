"""Paths of OMPL's planners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.quality.ompl_paths import PLANNERS, OmplPaths
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.paths.measure import path_contact
from planner.roadmap.straight_motions import Motions
from planner.sampling.joint_space import JointSpace
from planner.setup.open import make_query
from tests.benchmarks.quality.test_run import PLAIN


@pytest.mark.parametrize("name", PLANNERS)
def test_ompls_paths_join_the_ends_and_look_free(name: str) -> None:
    query = make_query(replace(PLAIN, scene="empty"))
    check = Motions(EdgeProver(query.checker)).looks_free(0.02)
    with OmplPaths(JointSpace.of(query.robot), check, np.random.default_rng(0)) as planners:
        path = planners.path(name, query.starts, query.goals, 0.3)
    assert path is not None
    assert (path[0] == query.starts[0]).all()
    assert (path[-1] == query.goals).all(axis=1).any()
    assert path_contact(make_checker(query.robot, query.scene, "coal"), path, 0.02) is None
