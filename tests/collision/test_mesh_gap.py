"""Distances of meshes: never above the truth, hardly below it, dents, holes and triangles without area included."""

from __future__ import annotations

import numpy as np
import pytest

from planner.collision.mesh_gap import PlacedSolid, Solid, hull_gap, surface_gap
from planner.studies.bench_attack.true_distance import true_distance
from planner.world.poses import pose
from planner.world.shapes import Box, Capsule, Mesh, Shape, Sphere
from tests.random_shapes import KINDS, blob, box_mesh, random_pose, random_shape
from tests.worlds import load


def placed(shape: Shape, place: np.ndarray) -> PlacedSolid:
    return PlacedSolid(Solid.of(shape), place[:3, :3], place[:3, 3])


def between(a: PlacedSolid, b: PlacedSolid) -> np.ndarray:
    return b.hull.middle - a.hull.middle


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.0, 0.05])
def test_a_bumpy_mesh_beside_anything(kind: str, share: float) -> None:
    rng, apart = np.random.default_rng(3), 0
    for _ in range(12 if kind == "mesh" else 25):
        mesh, other = blob(rng, float(rng.uniform(0.2, 1.0))), random_shape(rng, kind)
        p, q = random_pose(rng, 0.6), random_pose(rng, 0.6)
        true = true_distance((other, p), (mesh, q))
        a, b = placed(other, p), placed(mesh, q)
        gap, hull = surface_gap(a, b, share), hull_gap(a, b, between(a, b), np.inf)
        assert hull <= true.high + 1e-12
        assert gap <= true.high + 1e-12
        assert gap >= true.low - max(2e-6, 1.1 * share * true.low)
        assert surface_gap(b, a, share) == pytest.approx(gap, abs=max(2e-6, 1.1 * share * true.low))
        apart += true.low > 0.0
    assert apart > 5


def test_a_ball_in_a_dent_is_told_by_the_triangles() -> None:
    """Between two plates the hulls overlap; inside a closed mesh too: meshes are hollow."""
    plates = Mesh(
        np.array([[x, y, z] for z in (-0.2, 0.2) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float),
        np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]),
    )
    for mesh, gap in ((plates, 0.15), (box_mesh((1.0, 1.0, 1.0)), 0.45)):
        a, b = placed(Sphere(0.05), np.eye(4)), placed(mesh, np.eye(4))
        assert hull_gap(a, b, np.ones(3), np.inf) == 0.0
        assert surface_gap(a, b) == pytest.approx(gap, abs=1e-6)


def test_what_touches_has_no_gap() -> None:
    wall = Mesh(np.array([[0.0, -1, -1], [0.0, 1, -1], [0.0, 0, 1]]), np.array([[0, 1, 2]]))
    for shape in (Box((0.2, 0.1, 0.1)), Capsule(0.05, 0.1), box_mesh((0.2, 0.1, 0.1))):
        assert surface_gap(placed(shape, pose([0.02, 0, 0])), placed(wall, np.eye(4))) == 0.0


def test_triangles_without_area() -> None:
    needle = Mesh(np.array([[0.0, 0, 0], [1.0, 0, 0], [0.5, 0, 0]]), np.array([[0, 1, 2], [0, 0, 0]]))
    assert surface_gap(placed(Sphere(0.1), pose([0.3, 0.4, 0])), placed(needle, np.eye(4))) == pytest.approx(0.3)


@pytest.mark.parametrize("name", ["panda", "kinova", "ur5"])
def test_the_corners_that_are_kept_are_all_that_matter(name: str) -> None:
    rng = np.random.default_rng(0)
    for body in load(name).bodies:
        if isinstance(body.shape, Mesh):
            used = body.shape.vertices[np.unique(body.shape.triangles)]
            away = rng.normal(size=(3, 200))
            kept = Solid.of(body.shape).whole.points
            np.testing.assert_allclose((kept @ away).max(axis=0), (used @ away).max(axis=0), atol=1e-12)


def test_a_convex_mesh_is_its_hull_and_others_are_not() -> None:
    dented = box_mesh((1.0, 1.0, 1.0))
    corners = np.vstack([dented.vertices, [0.3, 0.0, 0.0]])
    triangles = dented.triangles[2:]  # the face at x = -0.5 becomes a pit
    pit = np.array([[a, b, 8] for a, b in ((0, 1), (1, 3), (3, 2), (2, 0))])
    assert Solid.of(dented).depth == 0.0
    assert Solid.of(Mesh(corners, np.vstack([triangles, pit]))).depth > 0.0
    assert Solid.of(Mesh(dented.vertices, triangles)).depth > 0.0  # open
    assert Solid.of(Box((1.0, 1.0, 1.0))).depth == 0.0
