"""Triangles without area are widened by a micrometre, and neither library is deceived by them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planner.collision import BACKENDS, make_checker
from planner.collision.checker import is_free
from planner.collision.degenerate_triangles import widened
from planner.kinematics.forward import joint_placements
from planner.robot.poses import pose
from planner.robot.shapes import Mesh, Sphere
from tests.random_shapes import box_mesh
from tests.worlds import body, load, scene_of

# a strip of which two corners coincide
STRIP = Mesh(
    np.array([[0, 0, -0.12], [0, 0, -0.12], [0.01, 0, 0.03], [0, 0.01, -0.12], [0, 0.01, -0.12], [0.01, 0.01, 0.03]]),
    np.array([[0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 5, 4]]),
)


def areas(mesh: Mesh) -> np.ndarray:
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1)


def test_a_mesh_without_needles_is_left_alone() -> None:
    mesh = box_mesh((0.1, 0.2, 0.3))
    assert widened(mesh) is mesh


@pytest.mark.parametrize(
    "corners",
    [[[0, 0, 0], [1, 0, 0], [0.3, 0, 0]], [[0, 0, 0], [0, 0, 0], [0, 0.5, 0]], [[2, 1, 0], [2, 1, 0], [2, 1, 0]]],
)
def test_needles_get_a_micrometre(corners: list[list[float]]) -> None:
    mesh = Mesh(np.array(corners, dtype=float), np.array([[0, 1, 2]]))
    wide = widened(mesh)
    assert areas(wide).min() > 0.0
    new = wide.vertices[wide.triangles[0]]
    for corner in mesh.vertices:  # each has one within a micrometre, and the longest side is there still
        assert np.linalg.norm(new - corner, axis=1).min() <= 2e-6
    long = max(np.linalg.norm(a - b) for a in mesh.vertices for b in mesh.vertices)
    assert max(np.linalg.norm(a - b) for a in new for b in new) >= long


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_large_ball_far_from_a_strip_with_coinciding_corners_is_free(backend: str) -> None:
    """FCL and coal called such balls touching that were 0.22 m and 0.56 m away."""
    robot = replace(load("planar_2r"), bodies=(replace(body(STRIP), joint=1),))
    free = 0
    for seed in range(20):
        away = np.random.default_rng(seed).normal(size=3)
        away *= 2.6 / np.linalg.norm(away)
        checker = make_checker(robot, scene_of((Sphere(2.27), pose(away.tolist()))), backend)
        rotation, position = joint_placements(checker.chain, np.zeros((1, 2)))
        distance = checker.distances(rotation[:, 0], position[:, 0], np.array([0]))[0]
        free += is_free(checker, np.zeros(2))
        assert distance > 0.15
    assert free == 20
