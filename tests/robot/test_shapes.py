"""Extents of shapes against points drawn from them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.robot.shapes import Mesh, Shape, corners, max_distance_from_axis, max_distance_from_origin
from tests.random_shapes import KINDS, QUICK, moved, points_in, poses, random_pose, random_shape, shapes

AXES = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1)


@QUICK
@given(shapes, poses, AXES, st.integers(0, 2**31))
def test_no_point_lies_farther_out(shape, placement, axis, seed):
    axis = np.array(axis) / np.linalg.norm(axis)
    points = moved(points_in(shape, np.random.default_rng(seed)), placement)
    assert np.linalg.norm(points, axis=1).max() <= max_distance_from_origin(shape, placement) + 1e-12
    across = points - np.outer(points @ axis, axis)
    assert np.linalg.norm(across, axis=1).max() <= max_distance_from_axis(shape, placement, axis) + 1e-12


@pytest.mark.parametrize("kind", KINDS)
def test_farthest_is_attained(kind):
    """The cylinder's is a bound, at most its radius too large (its rim is not solved for)."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        shape, placement = random_shape(rng, kind), random_pose(rng)
        points = moved(points_in(shape, rng, 20_000), placement)
        most = max_distance_from_origin(shape, placement)
        assert most - np.linalg.norm(points, axis=1).max() < 0.02 * most


@QUICK
@given(shapes, st.integers(0, 2**31))
def test_rounded_corners_contain_the_shape(shape: Shape, seed):
    """In every direction the rounded hull of the corners reaches at least as far as the shape."""
    rng = np.random.default_rng(seed)
    hull, radius = corners(shape)
    directions = rng.normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = points_in(shape, rng)
    assert ((points @ directions.T).max(axis=0) <= (hull @ directions.T).max(axis=0) + radius + 1e-12).all()


def test_a_mesh_is_frozen_and_its_own():
    vertices = np.eye(3)
    mesh = Mesh(vertices, np.array([[0, 1, 2]]))
    vertices[0, 0] = 7
    assert mesh.vertices[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 2
    with pytest.raises(ValueError, match="read-only"):
        mesh.triangles[0, 0] = 2
