"""The geometry of links: none is lost, large meshes are thinned whatever their name and scale, damage is an error."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planner.robot.files import meshes, urdf, urdf_geometry
from planner.robot.robot import Robot
from planner.robot.shapes import Mesh
from tests.random_shapes import box_mesh
from tests.robot.files.test_meshes import mesh_file
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
    np.testing.assert_allclose(np.ptp(shape.vertices, axis=0), [0.1, 0.2, 0.3], atol=1e-7)
