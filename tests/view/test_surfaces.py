"""Meshes to look at: creases keep their shape, tubes keep their radius."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.robot.shapes import Mesh
from planner.view.surfaces import smooth_mesh, tube
from tests.random_shapes import QUICK, blob, box_mesh


def sorted_triangles(mesh: Mesh) -> np.ndarray:
    """(m, 9) the triangles' corners, in an order of their own."""
    rows = mesh.vertices[mesh.triangles].reshape(-1, 9)
    return rows[np.lexsort(rows.T)]


def soup(mesh: Mesh) -> Mesh:
    """Every triangle with vertices of its own, as STL files have them."""
    return Mesh(mesh.vertices[mesh.triangles].reshape(-1, 3), np.arange(3 * len(mesh.triangles)).reshape(-1, 3))


def fine_sphere(rings: int = 24, sides: int = 48) -> Mesh:
    rng = np.random.default_rng(0)
    mesh = blob(rng, 2.0, rings, sides)
    return Mesh(mesh.vertices / np.linalg.norm(mesh.vertices, axis=1, keepdims=True), mesh.triangles)


@pytest.mark.parametrize("mesh", [box_mesh((1, 2, 3)), fine_sphere(), blob(np.random.default_rng(1), 1.0)])
def test_the_triangles_stay_where_they_are(mesh):
    for some in (mesh, soup(mesh)):
        made = smooth_mesh(some)
        assert isinstance(made, Mesh)
        np.testing.assert_allclose(sorted_triangles(made), sorted_triangles(some), atol=1e-9)


def test_a_box_stays_sharp_and_a_ball_is_welded():
    box, ball = smooth_mesh(soup(box_mesh((1, 2, 3)))), fine_sphere()
    assert len(box.vertices) == 24  # three at each corner
    welded = smooth_mesh(soup(ball))
    assert len(welded.vertices) <= 1.2 * len(ball.vertices)


# tubes


def radius_of(mesh: Mesh, points: np.ndarray, sides: int) -> np.ndarray:
    """Distance of every vertex from the point of the line that its ring belongs to."""
    rings = mesh.vertices.reshape(-1, sides, 3)
    assert len(rings) == len(points)
    return np.linalg.norm(rings - points[:, None], axis=2)


steps = st.lists(st.tuples(*[st.floats(-1, 1)] * 3), min_size=1, max_size=12)


def walk(parts) -> np.ndarray:
    """A line whose steps have at least 1 cm and never turn right back."""
    rows = [np.zeros(3)]
    ahead = np.array([1.0, 0, 0])
    for part in parts:
        ahead = np.array(part) + 1.2 * ahead / np.linalg.norm(ahead)
        rows.append(rows[-1] + 0.02 * ahead / np.linalg.norm(ahead))
    return np.array(rows)


@QUICK
@given(steps, st.sampled_from([3, 8, 10]))
def test_every_ring_has_the_radius(parts, sides):
    points = walk(parts)
    mesh = tube(points, 0.01, sides)
    assert np.isfinite(mesh.vertices).all()
    np.testing.assert_allclose(radius_of(mesh, points, sides), 0.01, rtol=1e-6)
    assert len(mesh.triangles) == 2 * sides * (len(points) - 1)
    assert mesh.triangles.max() == sides * len(points) - 1
