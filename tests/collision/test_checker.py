"""Every backend on one configuration and on several."""

from dataclasses import replace

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.checker import contact_at, is_free
from planner.robot.poses import pose
from planner.robot.shapes import Box, Mesh, Shape, Sphere
from tests.coal_judge import CoalWorld
from tests.worlds import body, load, random_q, scene_of

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
    first = int(touching.argmax())
    assert (found[0], str(found[1])) == (first, str(contact_at(checker, q[first])))
    assert checker.first_contact(q[~touching]) is None
    assert checker.robot is robot


STANDING = replace(load("planar_2r"), bodies=(body(Sphere(0.2)),), disabled_pairs=frozenset())
PLATE = Mesh(np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.0, 0.5, 0]]), np.array([[0, 1, 2]]))


@pytest.mark.parametrize("shape", [Sphere(0.3), Box((0.3, 0.4, 0.5)), PLATE])
@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_a_base_as_near_as_the_margin_touches_whatever_bounds_say(shape: Shape, backend: str) -> None:
    """Bounds round otherwise than libraries, and coal bends flat meshes by a micrometre."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        away = rng.normal(size=3)
        place = pose((1.2 * away / np.linalg.norm(away)).tolist(), quaternion=rng.normal(size=4).tolist())
        scene = scene_of((shape, place))
        gap = float(make_checker(STANDING, scene, backend).gaps(np.zeros(2), np.array([0]))[0])
        near, far = (make_checker(STANDING, scene, backend, margin) for margin in (gap, gap - 2e-4))
        assert str(near.static_contact) == "'link' and 'thing0'"
        assert far.static_contact is None
