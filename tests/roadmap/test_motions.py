"""Motions as tree planners check them."""

from __future__ import annotations

import numpy as np

from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability
from planner.roadmap.motions import Motions
from tests.worlds import checker_of, load


def test_motions_with_a_floor_refuse_what_dips() -> None:
    robot, prover = load("planar_2r"), EdgeProver(checker_of("planar_2r"))
    a, through_straight = np.array([0.0, 0.8]), np.array([0.0, -1.6])
    assert Motions(prover).proven(a, through_straight)
    assert not Motions(prover, 0.01).proven(a, through_straight)
    assert Motions(prover, 0.01).proven(a, np.array([1.0, 0.3]))
    assert not Motions(prover, 0.01).looks_free(0.05)(a, through_straight)
    assert manipulability(robot, a[None])[0] > 0.01
