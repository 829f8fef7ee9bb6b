"""Closed meshes as solids."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.robot.shapes import Box, Capsule, Mesh, Sphere
from planner.robot.solids import could_contain, is_watertight, points_of_components, shape_measures, solid_of
from tests.random_shapes import KINDS, QUICK, blob, box_mesh, moved, points_in, random_pose, random_shape

CUBE = box_mesh((1.0, 1.0, 1.0))


def box(size: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0), inward: bool = False) -> Mesh:
    """A box mesh; ``inward``: its triangles face the other way."""
    return Mesh(CUBE.vertices * size + np.array(at), CUBE.triangles[:, ::-1] if inward else CUBE.triangles)


def together(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(triangles))


def soup(mesh: Mesh) -> Mesh:
    """The same triangles with corners of their own, as STL files have them."""
    return Mesh(mesh.vertices[mesh.triangles].reshape(-1, 3), np.arange(mesh.triangles.size).reshape(-1, 3))


def inside(mesh: Mesh, *points: tuple[float, float, float]) -> list[bool]:
    solid = solid_of(mesh)
    return solid.contains(np.array(points)).tolist()


@pytest.mark.parametrize("made", [box(1.0), box(1.0, inward=True), soup(box(1.0))], ids=["out", "in", "soup"])
def test_a_box_holds_the_points_between_its_sides(made: Mesh) -> None:
    points = np.random.default_rng(0).uniform(-0.8, 0.8, (2000, 3))
    solid = solid_of(made)
    assert is_watertight(made)
    assert (solid.contains(points) == (np.abs(points) < 0.5).all(axis=1)).all()


@pytest.mark.parametrize("seed", range(5))
def test_a_bumpy_ball_holds_the_points_below_its_surface(seed: int) -> None:
    rng = np.random.default_rng(seed)
    made = blob(rng, 1.0)
    solid = solid_of(made)
    assert is_watertight(made)
    surface = points_in(made, rng)  # of a ball that is seen whole from its middle
    assert solid.contains(0.98 * surface).all()
    assert not solid.contains(1.02 * surface).any()


def test_a_hollow_body_is_hollow() -> None:
    room = together(box(3.0), box(2.0, inward=True))
    assert is_watertight(room)
    assert inside(room, (0, 0, 0), (1.2, 0, 0), (2, 0, 0)) == [False, True, False]


def test_only_closed_pieces_of_a_mesh_are_solid() -> None:
    plate = Mesh(np.array([[5.0, 0, 0], [6, 0, 0], [5, 1, 0]]), np.array([[0, 1, 2]]))
    partly = together(box(1.0), plate)
    assert not is_watertight(partly)
    assert inside(partly, (0, 0, 0), (5.2, 0.2, 0)) == [True, False]
    assert len(points_of_components(partly)) == 2


@given(st.integers(0, 2**32), st.sampled_from(KINDS))
@QUICK
def test_a_shape_in_a_solid_is_checked(seed: int, kind: str) -> None:
    rng, outer = np.random.default_rng(seed), solid_of(box(1.0))
    shape = random_shape(rng, kind)
    inside = np.abs(moved(points_in(shape, rng), random_pose(rng, 0.2))).max() < 0.5
    assert outer is not None
    assert could_contain(outer, shape_measures([shape])).tolist() in ([True], [inside])
    too_large = [Box((1.1, 1.1, 1.1)), Box((0.01, 0.01, 1.8)), Sphere(0.51), Capsule(0.01, 1.8), box(2.0)]
    assert not could_contain(outer, shape_measures(too_large)).any()
    assert could_contain(outer, shape_measures([together(box(0.1), box(0.1, (9, 0, 0)))])).all(), (
        "one piece may be inside"
    )
