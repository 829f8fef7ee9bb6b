"""Thinned meshes: the old surface lies within the rounding, inside stays inside, closed stays closed."""

import coal
import numpy as np
import pytest
import trimesh
from scipy.optimize import minimize

from planner.robot.files.meshes import CELL, read_display_mesh, read_mesh, simplify
from planner.robot.files.urdf_geometry import mesh_files
from planner.robot.shapes import Mesh
from planner.robot.solids import is_watertight, solid_of
from planner.view.drawing import load_drawn_bodies
from tests.coal_judge import coal_distance, coal_geometry
from tests.worlds import load


def ball(radius: float, rings: int = 60, shift: float = 0.0) -> Mesh:
    """A closed ball of many triangles, vertices a little away from it, so that nothing is regular."""
    u, v = np.meshgrid(np.arange(rings) / rings * 2 * np.pi, np.arange(1, rings) / rings * np.pi, indexing="ij")
    rows = radius * np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1).reshape(-1, 3)
    rows *= 1 + 0.01 * np.random.default_rng(0).uniform(-1, 1, size=(len(rows), 1))
    vertices = np.vstack([rows, [[0, 0, radius], [0, 0, -radius]]]) + shift
    count, triangles = rings - 1, []
    for k in range(rings):
        here, there = k * count + np.arange(count), (k + 1) % rings * count + np.arange(count)
        triangles += [[a, b, c] for a, b, c in zip(here[:-1], here[1:], there[:-1], strict=True)]
        triangles += [[a, b, c] for a, b, c in zip(here[1:], there[1:], there[:-1], strict=True)]
        triangles += [[len(rows), here[0], there[0]], [here[-1], len(rows) + 1, there[-1]]]
    return Mesh(vertices, np.array(triangles))


def distance(mesh: Mesh, point: np.ndarray) -> float:
    """How far a point is from the surface, by coal."""
    place = np.eye(4)
    place[:3, 3] = point
    return coal_distance(coal_geometry(mesh), np.eye(4), coal.Sphere(1e-9), place) + 1e-9


def test_no_point_of_the_surface_is_farther_away_than_the_rounding() -> None:
    mesh = ball(0.012)
    thin = simplify(mesh)
    assert len(thin.triangles) < 0.6 * len(mesh.triangles)
    assert 0 < thin.radius <= 0.5 * np.sqrt(3) * CELL + 1e-8
    corners, rng = mesh.vertices[mesh.triangles], np.random.default_rng(1)
    geometry = coal_geometry(thin)

    def away(weights: np.ndarray, triangle: np.ndarray) -> float:
        share = np.abs(weights) / np.abs(weights).sum()
        place = np.eye(4)
        place[:3, 3] = share @ triangle
        return -coal_distance(geometry, np.eye(4), coal.Sphere(1e-9), place)

    starts = [(away(w, corners[k]), k, w) for k in range(0, len(corners), 3) for w in [rng.dirichlet(np.ones(3))]]
    for _, k, weights in sorted(starts, key=lambda item: item[0])[:10]:  # climb from the worst
        found = minimize(away, weights, (corners[k],), method="Nelder-Mead", options={"maxiter": 80})
        assert -found.fun <= thin.radius + 1e-6
        assert -found.fun > 0.2 * thin.radius, "the attack comes near"


def test_closed_stays_closed_and_inside_stays_inside() -> None:
    mesh = ball(0.012)
    thin, solid = simplify(mesh), solid_of(mesh)
    assert is_watertight(mesh)
    assert is_watertight(thin)
    points = np.random.default_rng(2).uniform(-0.014, 0.014, size=(600, 3))
    points = np.array([p for p in points[::10] if distance(thin, p) > thin.radius])
    thin_solid = solid_of(thin)
    inside = solid.contains(points)
    assert inside.any()
    assert not inside.all()
    np.testing.assert_array_equal(thin_solid.contains(points), inside)


@pytest.mark.parametrize("needle", [[[0.05, 0, 0], [0.05, 1e-4, 0], [0.09, 0, 0]], [[0.05, 0, 0]] * 3])
def test_needles_and_specks_do_not_vanish(needle: list[list[float]]) -> None:
    mesh = ball(0.012)
    triangles = np.vstack([mesh.triangles, len(mesh.vertices) + np.arange(3)])
    thin = simplify(Mesh(np.vstack([mesh.vertices, needle]), triangles))
    used = thin.vertices[np.unique(thin.triangles)]
    for corner in np.array(needle):
        assert np.linalg.norm(used - corner, axis=1).min() <= thin.radius
    flat = thin.vertices[thin.triangles[-1]]
    assert np.abs(flat - np.array(needle)[[0, 2, 2]]).max() <= thin.radius, "a line, or a point"


def samples(mesh: Mesh, count: int) -> np.ndarray:
    """Points (count, 3) all over the surface, by area."""
    return trimesh.sample.sample_surface(trimesh.Trimesh(mesh.vertices, mesh.triangles), count, seed=3)[0]


def test_drawn_meshes_are_within_2_mm_of_their_files() -> None:
    robot, shares = load("panda"), []
    for file in sorted(set(mesh_files(robot.source, "visual"))):
        mesh, thin = read_mesh(file), read_display_mesh(file)
        assert (np.diff(np.sort(thin.triangles, axis=1), axis=1) > 0).all(), "each is seen"
        shares.append(len(thin.triangles) / len(mesh.triangles))
        for surface, other in ((mesh, thin), (thin, mesh)):
            geometry, place = coal_geometry(other), np.eye(4)
            for place[:3, 3] in samples(surface, 60):
                assert coal_distance(geometry, np.eye(4), coal.Sphere(1e-9), place) < 2e-3, file
    assert min(shares) < 0.6
    assert all(thin is body for thin, body in zip(load_drawn_bodies(robot)[1], robot.bodies, strict=True)), (
        "as they collide"
    )
