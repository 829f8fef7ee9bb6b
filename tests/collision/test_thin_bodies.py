"""Robots with thinned meshes: a contact with the mesh of the file is one for every checker and every proof."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.forward import joint_placements
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Mesh, Obstacle, Sphere
from tests.coal_judge import CoalWorld
from tests.robot.files.test_meshes import mesh_file
from tests.robot.files.test_simplify import ball
from tests.worlds import joint_xml, link_xml

MESH = ball(0.012)
RADIUS = 0.01


@pytest.fixture
def robot(urdf_file: Callable[..., str], tmp_path: Path) -> Robot:
    """A rough ball of 7,000 triangles on a slide along x, and one more that stands far away."""
    (tmp_path / "ball.stl").write_bytes(mesh_file(MESH))
    mesh = f'<mesh filename="{tmp_path / "ball.stl"}"/>'
    links = link_xml("a") + link_xml("b", mesh) + link_xml("far", mesh)
    joints = joint_xml("j", "a", "b", "prismatic", axis="1 0 0", limit="-0.2 0.2")
    return Robot.load(urdf_file(links + joints + joint_xml("w", "a", "far", "fixed", xyz="0 0 5")), tool="b")


def scene() -> Scene:
    place = np.eye(4)
    place[:3, 3] = 0.05, 0.006, 0.004
    return Scene("one", obstacles=(Obstacle("o", Sphere(RADIUS), place),))


def true_distances(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Distances of the obstacle from the mesh of the file, before thinning, by coal."""
    bodies = tuple(replace(body, shape=Mesh(MESH.vertices, MESH.triangles)) for body in robot.bodies[:1])
    whole = replace(robot, bodies=bodies)
    judge = CoalWorld(make_checker(replace(whole, disabled_pairs=frozenset()), scene()).world)
    return np.array([judge.distances(row)[0] for row in q])


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_a_contact_with_the_mesh_of_the_file_is_a_contact(robot: Robot, backend: str) -> None:
    assert all(isinstance(body.shape, Mesh) and body.shape.radius > 0 for body in robot.bodies)
    checker = make_checker(robot, scene(), backend)
    q = np.linspace(0.0, 0.1, 400)[:, None]
    truth = true_distances(robot, q)
    found = np.array([checker.first_contact(row[None]) is not None for row in q])
    assert found[truth <= 0].all()
    radius = max(body.shape.radius for body in robot.bodies if isinstance(body.shape, Mesh))
    assert not found[truth > 2 * radius + 1e-5].any()
    assert (found & (truth > 0)).any(), "the rounding is seen"


@pytest.mark.parametrize("backend", ["fcl", "coal"])
def test_no_distance_and_no_bound_exceeds_that_of_the_mesh_of_the_file(robot: Robot, backend: str) -> None:
    checker = make_checker(robot, scene(), backend)
    q = np.linspace(0.0, 0.1, 150)[:, None]
    truth, zero = true_distances(robot, q), np.zeros(1, dtype=np.int64)
    rotation, position = joint_placements(checker.chain, q)
    rows = np.arange(len(q))
    assert (checker.bound.coarse(rotation, position)[:, 0] <= truth + 1e-6).all()
    close = checker.bound.close(rotation, position, rows, np.zeros_like(rows))
    assert (close <= np.maximum(truth, 0) + 1e-6).all()
    enough = checker.bound.close(rotation, position, rows, np.zeros_like(rows), 0.005)
    np.testing.assert_array_equal(enough >= 0.005, close >= 0.005)
    found = np.array([checker.distances(rotation[:, k], position[:, k], zero)[0] for k in rows])
    assert (found <= np.maximum(truth, 0) + checker.error(0.1)).all()


def test_nothing_is_proven_that_touches_the_mesh_of_the_file(robot: Robot) -> None:
    prover = EdgeProver(make_checker(robot, scene()))
    ends, fine = np.linspace(0.0, 0.05, 60), np.linspace(0.0, 0.05, 600)
    truth = true_distances(robot, fine[:, None])
    proven = prover.free(np.zeros((60, 1)), ends[:, None])
    touched = np.array([truth[fine <= end].min() <= 0 for end in ends])
    assert proven.any()
    assert touched.any()
    assert not (proven & touched).any()
    assert (proven | (truth[np.searchsorted(fine, ends - 1e-12)] < 0.003)).all()


def test_a_mesh_that_changes_is_read_anew(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "ball.stl").write_bytes(mesh_file(Mesh(1.5 * MESH.vertices, MESH.triangles)))
    assert Robot.load(str(robot.source.path), tool="b").identity != robot.identity
