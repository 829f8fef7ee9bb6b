"""Meshes to look at: creases keep their shape, tubes keep their radius."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.models.shapes import Mesh
from planner.view.surfaces import creased, tube
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
        made = creased(some)
        np.testing.assert_array_equal(sorted_triangles(made), sorted_triangles(some))


def test_a_box_has_three_vertices_at_each_corner():
    assert len(creased(soup(box_mesh((1, 2, 3)))).vertices) == 24


def test_a_smooth_ball_is_welded():
    ball = fine_sphere()
    assert len(creased(soup(ball)).vertices) <= 1.2 * len(ball.vertices)


def test_normals_of_a_ball_point_outwards_and_of_a_box_along_its_axes():
    """Averaged over a vertex's triangles, as the viewer does."""
    for mesh, smooth in ((creased(soup(fine_sphere())), True), (creased(soup(box_mesh((1, 1, 1)))), False)):
        corners = mesh.vertices[mesh.triangles]
        face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        total = np.zeros_like(mesh.vertices)
        for k in range(3):
            np.add.at(total, mesh.triangles[:, k], face)
        normals = np.abs(total / np.linalg.norm(total, axis=1, keepdims=True))
        if smooth:
            assert (np.einsum("ij,ij->i", normals, np.abs(mesh.vertices)) > 0.98).all()
        else:
            np.testing.assert_allclose(normals.max(axis=1), 1.0, atol=1e-12)


def test_triangles_without_area_are_left_out():
    mesh = Mesh(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 1, 3], [0, 0, 1]]))
    made = creased(mesh)
    assert len(made.triangles) == 1
    flat = Mesh(mesh.vertices, mesh.triangles[:1])
    assert creased(flat) is flat


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


def test_a_straight_tube_does_not_twist():
    points = np.column_stack([np.linspace(0, 1, 20), np.zeros(20), np.zeros(20)])
    rings = tube(points, 0.1, 6).vertices.reshape(20, 6, 3) - points[:, None]
    np.testing.assert_allclose(rings, np.repeat(rings[:1], 20, axis=0), atol=1e-12)


def test_the_wall_is_closed_around():
    triangles = tube(np.eye(3), 0.05, 5).triangles
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)
    back = {tuple(edge[::-1]) for edge in edges}
    open_edges = [edge for edge in map(tuple, edges) if edge not in back]
    assert len(open_edges) == 2 * 5  # the two ends


@pytest.mark.parametrize("points", [np.zeros((1, 3)), np.ones((4, 3))])
def test_a_line_without_length_is_a_dot(points):
    mesh = tube(points, 0.01)
    assert np.isfinite(mesh.vertices).all()
    assert np.linalg.norm(mesh.vertices - points[0], axis=1).max() < 0.011


def test_points_that_repeat_are_left_out():
    line = np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 1, 0]])
    np.testing.assert_array_equal(tube(line, 0.1).vertices, tube(line[[0, 2, 4]], 0.1).vertices)


def test_a_line_that_turns_right_back():
    points = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, 0], [0.1, 0, 0], [0.0, 0, 0]])
    assert np.isfinite(tube(points, 0.01).vertices).all()
