"""What is drawn of a robot: the same from the cache as from its meshes, and whatever becomes of the cache."""

from __future__ import annotations

import gzip
import os
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.models.robot import Robot, load_visuals, with_carried
from planner.models.shapes import Body, Carried, Mesh, Sphere, corners
from planner.view import visuals
from planner.view.canvas import Canvas
from planner.view.commands import packed
from planner.view.drawing import draw_bodies, swept_corners
from planner.view.surfaces import creased, smoothed
from planner.view.visuals import draw_robot, drawn_bodies, visuals_of
from tests.models.files.test_meshes import mesh_file
from tests.random_shapes import box_mesh
from tests.view.test_canvas import unpacked
from tests.view.test_drawing import is_red
from tests.worlds import joint_xml, load, random_q


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "planner" / "visuals"


def contents(bodies: Iterable[Body]) -> list[list[object]]:
    rows = [[b.name, b.link, b.joint, b.color, b.placement.tolist(), *b.shape.content()] for b in bodies]
    return [[item.tolist() if isinstance(item, np.ndarray) else item for item in row] for row in rows]


@pytest.fixture
def robot() -> Robot:
    return Robot.load("planar_2r")


def test_a_second_look_reads_no_mesh(monkeypatch: pytest.MonkeyPatch, cache: Path) -> None:
    robot = Robot.load("ur5")
    first = drawn_bodies(robot)
    assert len(list(cache.glob("*.kept"))) == 1
    monkeypatch.setattr(visuals, "load_visuals", lambda robot: pytest.fail("read again"))
    assert contents(drawn_bodies(robot)) == contents(first)
    loaded, drawn = (
        [body.shape for body in bodies if isinstance(body.shape, Mesh)] for bodies in (load_visuals(robot), first)
    )
    assert [len(creased(mesh).vertices) for mesh in loaded] == [len(mesh.vertices) for mesh in drawn]


def test_another_base_is_another_robot_to_look_at(robot: Robot, cache: Path) -> None:
    drawn_bodies(robot)
    moved = Robot.load("planar_2r", base=np.diag([-1.0, -1.0, 1.0, 1.0]))
    assert contents(drawn_bodies(moved)) == contents(load_visuals(moved))
    assert len(list(cache.glob("*.kept"))) == 2


def test_another_mesh_in_the_same_file_is_seen(urdf_file: Callable[..., str], tmp_path: Path) -> None:
    """Of the same size and said to be as old: only the file system knows."""
    mesh, file = box_mesh((0.1, 0.2, 0.3)), tmp_path / "box.stl"
    seen = f'<visual><geometry><mesh filename="file://{file}"/></geometry></visual>'
    path = urdf_file(f'<link name="a"/><link name="b">{seen}</link>' + joint_xml("j", "a", "b"))
    for size in (1.0, 2.0):
        file.write_bytes(mesh_file(Mesh(size * mesh.vertices, mesh.triangles)))
        os.utime(file, (1e9, 1e9))
        (drawn,) = drawn_bodies(Robot.load(path))
        assert np.ptp(corners(drawn.shape)[0], axis=0) == pytest.approx(size * np.array([0.1, 0.2, 0.3]))


def test_another_body_that_collides_is_seen(robot: Robot) -> None:
    other = replace(robot.bodies[0], shape=Sphere(0.2))
    assert visuals_of(replace(robot, bodies=(other, *robot.bodies[1:]))).commands != visuals_of(robot).commands


def test_what_touches_is_red_and_what_is_carried_is_drawn_as_both_kinds() -> None:
    robot = with_carried(load("ur5"), [Carried("tool0", "cup", Sphere(0.05), np.eye(4))])
    packages = []
    for touching in (frozenset[str](), frozenset({"cup"}), frozenset({robot.bodies[0].link})):
        canvas = Canvas()
        names, boxes = draw_robot(canvas, robot, np.zeros(6), touching)
        assert list(names.values()).count("cup") == 2
        assert len(names) == len(boxes) + len(robot.bodies)
        drawn = {c["path"].removeprefix("/meshcat/"): c for c in unpacked(canvas) if c["type"] == "set_object"}
        assert set(drawn) == set(names)
        assert {names[path] for path, command in drawn.items() if is_red(command)} == touching
        packages.append(len(canvas.packed()[1]))
    assert packages == [2, 2, 1], "what is kept is taken where none of it is red"


def test_a_damaged_file_is_made_anew(robot: Robot, cache: Path) -> None:
    first, commands = contents(drawn_bodies(robot)), visuals_of(robot).commands.content
    for kept in cache.glob("*.kept"):
        whole = kept.read_bytes()
        for content in (b"", whole[:-1], whole[:100] + bytes([whole[100] ^ 1]) + whole[101:]):
            kept.write_bytes(content)
            assert contents(drawn_bodies(robot)) == first
            assert visuals_of(robot).commands.content == commands
            assert kept.read_bytes() == whole


def test_what_stands_in_for_meshes_is_not_kept(robot: Robot, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visuals, "load_visuals", lambda robot: robot.bodies)
    assert [body.name for body in drawn_bodies(robot)] == [body.name for body in robot.bodies]
    assert len(visuals_of(robot).boxes) == len(robot.bodies)
    assert not cache.exists()


def test_without_a_place_to_keep_it_everything_is_drawn(robot: Robot, cache: Path) -> None:
    cache.parent.write_text("a file where the folder should be")
    assert len(drawn_bodies(robot)) == len(load_visuals(robot))


def test_what_is_carried_is_not_kept(robot: Robot) -> None:
    held = replace(robot.bodies[-1], name="cup")
    assert contents(drawn_bodies(replace(robot, carried=(held,)))) == contents(drawn_bodies(robot))


@pytest.mark.parametrize("name", ["ur5", "planar_2r"])
def test_what_a_page_takes_are_the_bodies(name: str) -> None:
    robot, canvas = Robot.load(name), Canvas()
    for found in (visuals_of(robot), visuals_of(robot)):  # made, and read
        bodies = drawn_bodies(robot)
        draw_bodies(canvas, "visual", bodies)
        draw_bodies(canvas, "collision", [replace(body, shape=smoothed(body.shape)) for body in robot.bodies])
        expected = packed(canvas.commands)
        canvas.commands.clear()
        assert gzip.decompress(found.commands.content) == gzip.decompress(expected.content)
        assert found.commands.lengths == expected.lengths
        assert [(b.name, b.link, b.joint) for b in found.boxes] == [(b.name, b.link, b.joint) for b in bodies]
        for q in random_q(robot, 3):
            np.testing.assert_allclose(
                swept_corners(robot, found.boxes, q[None]), swept_corners(robot, bodies, q[None])
            )
