"""What every backend answers of one configuration and of several."""

from __future__ import annotations

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.checker import contact_of, is_free
from planner.models.poses import pose
from planner.models.shapes import Sphere
from tests.coal_judge import CoalWorld
from tests.worlds import load, random_q, scene_of

BALLS = scene_of((Sphere(0.15), pose([0.6, 0.3, 0.0])), (Sphere(0.1), pose([-0.5, -0.5, 0.0])))


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_the_first_contact_is_the_first_row_that_is_not_free(backend: str) -> None:
    robot = load("planar_2r")
    checker = make_checker(robot, BALLS, backend)
    q = random_q(robot, 40)
    nearest = np.array([CoalWorld(checker.world).distances(row).min() for row in q])
    touching = nearest <= 0
    assert touching.any()
    assert [is_free(checker, row) for row in q] == (~touching).tolist()
    found = checker.first_contact(q)
    assert found is not None
    first = int(touching.argmax())
    assert (found[0], str(found[1])) == (first, str(contact_of(checker, q[first])))
    assert checker.first_contact(q[~touching]) is None
    assert checker.robot is robot


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_asking_is_counted(backend: str) -> None:
    checker = make_checker(load("planar_2r"), BALLS, backend)
    before = checker.queries
    is_free(checker, np.zeros(2))
    assert checker.queries > before
    assert 0 <= checker.error(0.1) < 1e-3
