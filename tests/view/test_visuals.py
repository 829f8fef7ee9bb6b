"""The drawn bodies of a robot: the same from the cache as from its meshes, and whatever becomes of the cache."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

from planner.robot.robot import Robot, with_carried
from planner.robot.shapes import Body, Carried, Mesh, Sphere, corners
from planner.view import drawing
from planner.view.canvas import Canvas
from planner.view.drawing import draw_robot, drawn_bodies
from tests.random_shapes import box_mesh
from tests.robot.files.test_meshes import mesh_file
from tests.view.test_canvas import unpacked
from tests.view.test_drawing import is_red
from tests.worlds import joint_xml, load


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "planner" / "drawn"


def contents(bodies: Iterable[Body]) -> list[list[object]]:
    rows = [[b.name, b.link, b.joint, b.color, b.placement.tolist(), *b.shape.content()] for b in bodies]
    return [[item.tolist() if isinstance(item, np.ndarray) else item for item in row] for row in rows]


@pytest.fixture
def robot() -> Robot:
    return Robot.load("planar_2r")


def test_a_second_look_reads_no_mesh(monkeypatch: pytest.MonkeyPatch, cache: Path) -> None:
    robot = Robot.load("ur5")
    first = drawn_bodies(robot)
    assert len(list(cache.glob("*.npz"))) == 1
    monkeypatch.setattr(drawing, "load_visuals", lambda robot: pytest.fail("read again"))
    assert contents(drawn_bodies(robot)[0]) == contents(first[0])
    assert contents(drawn_bodies(robot)[1]) == contents(first[1])


def test_another_mesh_in_the_same_file_is_seen(urdf_file: Callable[..., str], tmp_path: Path) -> None:
    """Of the same size and said to be as old: only the file system knows."""
    mesh, file = box_mesh((0.1, 0.2, 0.3)), tmp_path / "box.stl"
    seen = f'<visual><geometry><mesh filename="file://{file}"/></geometry></visual>'
    path = urdf_file(f'<link name="a"/><link name="b">{seen}</link>' + joint_xml("j", "a", "b"))
    for size in (1.0, 2.0):
        file.write_bytes(mesh_file(Mesh(size * mesh.vertices, mesh.triangles)))
        os.utime(file, (1e9, 1e9))
        (drawn,), _ = drawn_bodies(Robot.load(path))
        assert np.ptp(corners(drawn.shape)[0], axis=0) == pytest.approx(size * np.array([0.1, 0.2, 0.3]))


def test_contacts_are_red_and_a_carried_body_is_drawn_as_both_kinds() -> None:
    robot = with_carried(load("ur5"), [Carried("tool0", "cup", Sphere(0.05), np.eye(4))])
    for touching in (frozenset[str](), frozenset({"cup"}), frozenset({robot.bodies[0].link})):
        canvas = Canvas()
        names, bodies = draw_robot(canvas, robot, np.zeros(6), touching)
        assert list(names.values()).count("cup") == 2
        assert len(names) == len(bodies) + len(robot.bodies)
        drawn = {c["path"].removeprefix("/meshcat/"): c for c in unpacked(canvas) if c["type"] == "set_object"}
        assert set(drawn) == set(names)
        assert {names[path] for path, command in drawn.items() if is_red(command)} == touching


def test_stand_ins_for_meshes_are_not_kept(robot: Robot, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "load_visuals", lambda robot: robot.bodies)
    assert [body.name for body in drawn_bodies(robot)[0]] == [body.name for body in robot.bodies]
    assert not cache.exists()
