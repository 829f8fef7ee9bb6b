"""Packages are found by the name in their package.xml, and meshes and includes through them."""

import os
from pathlib import Path

import pytest

from planner.robot.files.packages import PATHS, find_package
from planner.robot.robot import Robot
from tests.worlds import joint_xml, link_xml

XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
TETRAHEDRON = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def package(folder: Path, name: str, size: float = 0.1) -> Path:
    """A package with a mesh of this size and a URDF that names the mesh by the package ``name``."""
    (folder / "meshes").mkdir(parents=True)
    (folder / "urdf").mkdir()
    (folder / "package.xml").write_text(f"<package format='3'><name> {name}\n</name></package>")
    (folder / "meshes" / "a.obj").write_text(TETRAHEDRON.format(size))
    mesh = link_xml("b", f'<mesh filename="package://{name}/meshes/a.obj"/>')
    text = f'<robot name="arm" {{}}>{link_xml("a")}{mesh}{joint_xml("j", "a", "b")}</robot>'
    (folder / "urdf" / "arm.urdf").write_text(text.format(""))
    (folder / "urdf" / "arm.urdf.xacro").write_text(text.format(XACRO))
    return folder


def size_of(robot: Robot) -> float:
    return float(robot.bodies[0].shape.vertices.max())


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    for path in PATHS:
        monkeypatch.delenv(path, raising=False)


@pytest.mark.parametrize("file", ["urdf/arm.urdf", "urdf/arm.urdf.xacro"])
def test_two_clones_of_one_package_keep_their_own_meshes(tmp_path: Path, file: str) -> None:
    if file.endswith(".xacro"):
        pytest.importorskip("xacro")
    clones = {size: package(tmp_path / f"clone{size}", "arm_description", size) for size in (0.1, 0.2)}
    for size, clone in clones.items():
        assert size_of(Robot.load(clone / file)) == pytest.approx(size)


@pytest.mark.parametrize(
    ("variable", "value", "place"),
    [
        ("ROS_PACKAGE_PATH", "ws", "ws/src/group/folder"),
        ("ROS_PACKAGE_PATH", f"nowhere{os.pathsep}ws/folder", "ws/folder"),
        ("AMENT_PREFIX_PATH", f"nowhere{os.pathsep}install", "install/share/acme"),
        ("ROS_PACKAGE_PATH", "", "folder"),  # a neighbour of the URDF's own package
    ],
)
def test_where_packages_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variable: str, value: str, place: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(variable, value)
    there = package(tmp_path / place, "acme")
    far = package(tmp_path / "own" / "arm", "own") / "urdf" / "other.urdf"
    (there / "urdf" / "arm.urdf").rename(far)
    assert size_of(Robot.load(far)) == pytest.approx(0.1)
    assert find_package("acme", far) == there
