"""Covers contain their shape: points drawn from it lie in one of the spheres, or boxes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.collision import BACKENDS, make_checker
from planner.collision.bounding_volumes import box_cover, dent_depth, sphere_cover, widen_triangles
from planner.collision.checker import is_free
from planner.kinematics.forward import joint_placements
from planner.robot.poses import pose
from planner.robot.shapes import Mesh, Sphere
from tests.random_shapes import QUICK, blob, box_mesh, points_in, shapes
from tests.worlds import body, load, scene_of

COUNTS = st.sampled_from([1, 2, 3, 6, 17, 48])


def depth(cover, points) -> np.ndarray:
    """How far each point lies inside the nearest sphere (negative: outside all of them)."""
    apart = np.linalg.norm(points[:, None] - cover.centres[None], axis=2)
    return (cover.radii[None] - apart).max(axis=1)


@QUICK
@given(shapes, COUNTS, st.sampled_from([0.0, 0.02, 0.08]), st.integers(0, 2**31))
def test_every_point_lies_in_a_sphere(shape, count, enough, seed):
    cover = sphere_cover(shape, count, enough)
    points = points_in(shape, np.random.default_rng(seed), 300)
    assert depth(cover, points).min() >= -1e-9
    assert len(cover.centres) == len(cover.radii) <= max(count, 2)


@QUICK
@given(st.integers(0, 2**31), st.floats(0.01, 2), COUNTS)
def test_every_point_of_a_mesh_lies_in_a_box(seed, size, count):
    rng = np.random.default_rng(seed)
    mesh = blob(rng, size)
    centres, halves = box_cover(mesh, count)
    beyond = np.abs(points_in(mesh, rng)[:, None] - centres[None]) - halves[None]
    assert beyond.max(axis=2).min(axis=1).max() <= 1e-12
    assert len(centres) == min(count, len(mesh.triangles))


def notched(depth: float) -> Mesh:
    """A unit cube whose top face is drawn in to a pit of that depth."""
    box = box_mesh((1.0, 1.0, 1.0))
    top = np.isclose(box.vertices[box.triangles][..., 2], 0.5).all(axis=1)
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    ring = np.column_stack([square, np.full(4, 0.5)])
    vertices = np.vstack([box.vertices, ring, [[0.0, 0.0, 0.5 - depth]]])
    n = len(box.vertices)
    pit = [[n + k, n + (k + 1) % 4, n + 4] for k in range(4)]
    return Mesh(vertices, np.vstack([box.triangles[~top], pit]))


def test_a_convex_mesh_has_no_dent() -> None:
    assert dent_depth(box_mesh((0.1, 0.2, 0.3))) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("depth", [0.01, 0.2])
def test_a_pit_is_as_deep_as_it_says(depth: float) -> None:
    found = dent_depth(notched(depth))
    assert found >= depth * (1 - 1e-9)
    assert found <= 2.5 * depth


def test_an_open_mesh_has_no_bound() -> None:
    box = box_mesh((0.1, 0.2, 0.3))
    assert dent_depth(Mesh(box.vertices, box.triangles[:-1])) == np.inf


# a strip of which two corners coincide
STRIP = Mesh(
    np.array([[0, 0, -0.12], [0, 0, -0.12], [0.01, 0, 0.03], [0, 0.01, -0.12], [0, 0.01, -0.12], [0.01, 0.01, 0.03]]),
    np.array([[0, 1, 3], [1, 4, 3], [1, 2, 4], [2, 5, 4]]),
)


def areas(mesh: Mesh) -> np.ndarray:
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1)


@pytest.mark.parametrize(
    "corners",
    [[[0, 0, 0], [1, 0, 0], [0.3, 0, 0]], [[0, 0, 0], [0, 0, 0], [0, 0.5, 0]], [[2, 1, 0], [2, 1, 0], [2, 1, 0]]],
)
def test_needles_get_a_micrometre(corners: list[list[float]]) -> None:
    mesh = Mesh(np.array(corners, dtype=float), np.array([[0, 1, 2]]))
    wide = widen_triangles(mesh)
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
