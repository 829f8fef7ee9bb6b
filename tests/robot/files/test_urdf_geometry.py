"""The geometry of links: none is lost, large meshes are thinned whatever their name and scale, damage is told."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planner.robot.files import meshes, urdf, urdf_geometry
from planner.robot.robot import Robot
from planner.robot.shapes import Mesh, Sphere
from tests.random_shapes import box_mesh
from tests.robot.files.test_meshes import mesh_file
from tests.robot.files.test_thinned import ball
from tests.worlds import ROBOTS, joint_xml, link_xml, load


@pytest.mark.parametrize("name", ROBOTS)
def test_no_collision_geometry_is_lost(name: str) -> None:
    robot = load(name)
    assert robot.source.collision_elements == robot.source.xml.count("<collision") > 0
    read, _ = urdf_geometry.read_geometry(robot.source, urdf.build_model(robot.source), "collision")
    assert len(robot.bodies) == read.ngeoms >= robot.source.collision_elements
    for item in robot.bodies:
        if isinstance(item.shape, Mesh):
            assert item.shape.triangles.max() < len(item.shape.vertices)
            assert np.ptp(item.shape.vertices, axis=0).max() < 1.0  # metres, not millimetres


def test_large_meshes_are_thinned_in_their_place(urdf_file: Callable[..., str], tmp_path: Path) -> None:
    mesh = ball(0.012)
    (tmp_path / "ball.stl").write_bytes(mesh_file(Mesh(1000 * mesh.vertices, mesh.triangles)))
    shape = f'<mesh filename="file://{tmp_path / "ball.stl"}" scale="0.001 -0.001 0.001"/>'
    two = f"<collision><geometry>{shape}</geometry></collision><collision><origin xyz='0 0 1'/><geometry>{shape}"
    links = link_xml("a", '<sphere radius="0.3"/>')
    links += f'<link name="b"><collision><geometry><sphere radius="0.2"/></geometry></collision>{two}</geometry>'
    robot = Robot.load(urdf_file(f"{links}</collision></link>" + joint_xml("j", "a", "b", xyz="0 0 2")))
    plain, small, first, second = robot.bodies
    assert (plain.shape, small.shape) == (Sphere(0.3), Sphere(0.2))
    assert isinstance(first.shape, Mesh)
    assert first.shape is second.shape, "read once"
    assert first.shape.radius > 0
    np.testing.assert_allclose(second.placement[:3, 3] - first.placement[:3, 3], [0, 0, 1])
    mirrored = mesh.vertices * [1, -1, 1]
    np.testing.assert_allclose(first.shape.vertices.max(axis=0), mirrored.max(axis=0), atol=1e-3)
    np.testing.assert_allclose(first.shape.vertices.min(axis=0), mirrored.min(axis=0), atol=1e-3)


@pytest.mark.parametrize("named", ["package://{}", "package:///{}", "model://{}", "file://{folder}/{}", "{folder}/{}"])
def test_a_mesh_is_read_once_however_it_is_named(
    named: str, urdf_file: Callable[..., str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "parts").mkdir()
    box = box_mesh((0.1, 0.2, 0.3))
    (tmp_path / "parts" / "box.stl").write_bytes(mesh_file(box))
    mesh = f'<mesh filename="{named.format("parts/box.stl", folder=tmp_path)}"/>'
    path = urdf_file(link_xml("a") + link_xml("b", mesh) + joint_xml("j", "a", "b"))
    first = Robot.load(path)
    monkeypatch.setattr(meshes, "read_mesh", lambda *_: pytest.fail("the file was read again"))
    monkeypatch.setattr(urdf_geometry, "shape_of", lambda _: pytest.fail("Pinocchio read it"))
    assert Robot.load(path).identity == first.identity
    shape = first.bodies[0].shape
    assert isinstance(shape, Mesh)
    np.testing.assert_allclose(np.ptp(shape.vertices, axis=0), [0.1, 0.2, 0.3], atol=1e-7)
