"""Paths out of badly conditioned configurations."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability
from planner.roadmap.escape_singularity import ascend_manipulability
from planner.trajectory.measure import path_contact
from tests.worlds import checker_of, load


@pytest.mark.parametrize("name", ["iiwa14", "panda", "ur5"])
def test_climbing_rises_all_the_way(name: str) -> None:
    robot, checker = load(name), checker_of(name)
    rng, done = np.random.default_rng(2), 0
    for q in rng.uniform(robot.lower, robot.upper, (12, robot.dof)):
        start = float(manipulability(robot, q[None])[0])
        if not checker.bound.looks_free(q[None]) or start > 0.02:
            continue
        way = ascend_manipulability(EdgeProver(checker), q, 0.03)
        share = np.linspace(0, 1, 12)[:, None]
        w = manipulability(robot, np.concatenate([a + share * (b - a) for a, b in itertools.pairwise(way)]))
        assert w.min() >= start - 1e-12
        assert w[-1] >= 0.03
        assert path_contact(checker, way) is None
        done += 1
    assert done


def test_a_state_above_the_floor_needs_no_climb() -> None:
    q = np.array([0.0, 0.5, 0, -1.2, 0, 0.8, 0])
    assert len(ascend_manipulability(EdgeProver(checker_of("iiwa14")), q, 1e-3)) == 1
