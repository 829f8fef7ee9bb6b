"""Clearance of configurations."""

from __future__ import annotations

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.collision.clearance import Clearance
from planner.kinematics.forward import joint_placements
from planner.robot.scene import Scene
from tests.worlds import checker_of, load, random_q


@pytest.mark.parametrize(("robot", "scene"), [("iiwa14", "paper"), ("ur5", "table"), ("planar_2r", "window")])
def test_clearance_agrees_with_coal_and_with_state_checks(robot: str, scene: str) -> None:
    fcl, coal = checker_of(robot, scene), make_checker(load(robot), Scene.load(scene), backend="coal")
    q = random_q(load(robot), 60)
    ours, theirs = Clearance(fcl)(q), Clearance(coal)(q)
    free = np.array([is_free(fcl, each) for each in q])
    assert free.any()
    assert not free.all()
    np.testing.assert_array_equal(ours[free] > 0, True)
    np.testing.assert_allclose(ours[free], theirs[free], atol=2e-4)
    np.testing.assert_allclose(ours[~free], 0.0, atol=1e-6)


@pytest.mark.parametrize("below", [0.0, 0.02, 0.1, np.inf])
def test_below_is_where_clearances_are_exact(below: float) -> None:
    """Lower bounds elsewhere, of ``below`` or more."""
    clearance, q = Clearance(checker_of("ur5", "table")), random_q(load("ur5"), 60)
    exact, found = clearance(q), clearance(q, below)
    near = exact < below
    np.testing.assert_array_equal(found[near], exact[near])
    assert (found[~near] >= below).all()
    assert (found <= exact).all()


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_distances_of_many_configurations_are_those_of_each(backend: str) -> None:
    checker = make_checker(load("ur5"), Scene.load("table"), backend=backend)
    rotation, position = joint_placements(checker.chain, random_q(load("ur5"), 12))
    rng, pairs = np.random.default_rng(0), np.flatnonzero(checker.world.moving)
    rows, asked = rng.integers(0, 12, 40), rng.choice(pairs, 40)
    each = [
        checker.distances(rotation[:, r], position[:, r], np.array([p]))[0] for r, p in zip(rows, asked, strict=True)
    ]
    np.testing.assert_array_equal(checker.distances_in(rotation, position, rows, asked), each)


def test_no_configuration_has_no_clearance() -> None:
    assert Clearance(checker_of("ur5", "table"))(np.zeros((0, 6))).shape == (0,)
