"""Convex hulls of meshes, and dents below them, against shapes whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from planner.collision.hulls import dent, hull_corners
from planner.robot.shapes import Mesh
from tests.random_shapes import box_mesh


def in_hull(point: np.ndarray, corners: np.ndarray) -> bool:
    """By linear programming: a convex combination of the corners."""
    equal = np.vstack([corners.T, np.ones(len(corners))])
    return linprog(np.zeros(len(corners)), A_eq=equal, b_eq=[*point, 1.0]).status == 0


def test_fewer_points_have_the_same_hull() -> None:
    points = np.random.default_rng(0).normal(size=(300, 3))
    corners = hull_corners(points)
    assert len(corners) < 150
    assert all(in_hull(point, corners) for point in points[::10])


def test_few_points_and_flat_ones_stay() -> None:
    few = np.random.default_rng(1).normal(size=(5, 3))
    assert len(hull_corners(np.repeat(few, 3, axis=0))) == 5
    flat = np.column_stack([np.random.default_rng(2).normal(size=(300, 2)), np.zeros(300)])
    assert len(hull_corners(flat)) == 300


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
    assert dent(box_mesh((0.1, 0.2, 0.3))) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("depth", [0.01, 0.2])
def test_a_pit_is_as_deep_as_it_says(depth: float) -> None:
    found = dent(notched(depth))
    assert found >= depth * (1 - 1e-9)
    assert found <= 2.5 * depth


def test_an_open_mesh_has_no_bound() -> None:
    box = box_mesh((0.1, 0.2, 0.3))
    assert dent(Mesh(box.vertices, box.triangles[:-1])) == np.inf
