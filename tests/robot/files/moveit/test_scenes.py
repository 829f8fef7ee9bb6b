"""PlanningScene messages and scene texts: shapes, placements, permissions and attached objects."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from planner.collision import make_checker
from planner.collision.checker import contact_at
from planner.robot.moveit.scenes import parse_planning_scene, parse_scene_text
from planner.robot.robot import Robot, with_carried
from planner.robot.robot_in_scene import notes
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Cylinder, Sphere
from tests.refusals import refusal_of
from tests.robot.files.moveit.samples import BOX, HERE, scene
from tests.worlds import load


def test_the_matrix_allows_robot_against_object_only(tmp_path: Path) -> None:
    lump = {
        "id": "lump",
        "primitives": [{"type": "sphere", "dimensions": [0.2]}],
        "primitive_poses": [{"position": [0, 0, 1.3]}],
    }
    names = [f"iiwa14_link_{k}" for k in range(8)]
    everything = [[True] * 9 for _ in range(9)]
    allowing = scene(lump, allowed_collision_matrix={"entry_names": [*names, "lump"], "entry_values": everything})
    for message, touches in ((scene(lump), True), (allowing, False)):
        (tmp_path / "s.yaml").write_text(yaml.safe_dump(message))
        robot, world = Robot.load("iiwa14"), Scene.load(str(tmp_path / "s.yaml"))
        checker = make_checker(robot, world)
        assert (contact_at(checker, np.zeros(7)) is not None) == touches
        # what a matrix says of two robot links changes nothing
        assert len(checker.world.self_pairs) == len(make_checker(robot, Scene("none")).world.self_pairs)
    assert Scene.load(str(tmp_path / "s.yaml")).identity != Scene("x", world.obstacles).identity


def _written(folder: Path, **more: object) -> Scene:
    (folder / "s.yaml").write_text(yaml.safe_dump(scene(BOX, **more)))
    return Scene.load(str(folder / "s.yaml"))


def _matrix(*names: str, allowed: bool = False) -> dict:
    return {"entry_names": list(names), "entry_values": [[allowed] * len(names) for _ in names]}


TWO = {**BOX, "id": "pair", **{key: 2 * BOX[key] for key in ("primitives", "primitive_poses")}}


def test_a_permission_for_an_attached_object_is_for_all_its_shapes(tmp_path: Path) -> None:
    held = {"attached_collision_objects": [{"link_name": "panda_hand", "object": TWO}]}
    said = _written(tmp_path, robot_state=held, allowed_collision_matrix=_matrix("pair", "crate", allowed=True))
    robot = with_carried(load("panda"), said.carried)
    checked = make_checker(robot, said).world.checked[:, 0]
    assert {body.link for body, each in zip(robot.bodies, checked, strict=True) if not each} == {"pair.0", "pair.1"}
    said = _written(tmp_path, robot_state=held, allowed_collision_matrix=_matrix("pair", "panda_link5", allowed=True))
    (note,) = notes(robot, said)
    assert note.text.endswith("but the SRDF overrides it: pair and panda_link5.")


def test_boxes_cylinders_spheres_and_meshes_stand_where_the_message_says() -> None:
    (crate,) = parse_planning_scene(scene(BOX), HERE).obstacles
    assert (crate.name, crate.object, crate.shape) == ("crate", "crate", Box((0.1, 0.2, 0.3)))
    np.testing.assert_allclose(crate.placement[:3, [0, 3]].T, [[0, 1, 0], [1, 2, 3]], atol=1e-12)
    shapes = [{"type": 3, "dimensions": [0.14, 0.03]}, {"type": "sphere", "dimensions": [0.2]}]  # height, radius
    places = [{}, {"position": {"x": 1, "y": 0, "z": 0}}]
    can = {"id": "can", "primitives": shapes, "primitive_poses": places, "pose": {"position": [0, 0, 1]}}
    first, second = parse_planning_scene(scene(can), HERE).obstacles
    assert (first.name, second.name, first.object, second.object) == ("can.0", "can.1", "can", "can")
    assert (first.shape, second.shape) == (Cylinder(0.03, 0.14), Sphere(0.2))
    np.testing.assert_allclose(second.placement[:3, 3], [1, 0, 1])
    for triangle in ({"vertex_indices": [0, 1, 2]}, [0, 1, 2]):
        mesh = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [triangle]}
        (sheet,) = parse_planning_scene(scene({"id": "sheet", "mesh_poses": [{}], "meshes": [mesh]}), HERE).obstacles
        assert sheet.shape.triangles.tolist() == [[0, 1, 2]]


OLD_TEXT = (
    "(noname)++\n* Box0\n1\nbox\n0.1 0.2 0.3\n1 2 3\n0 0 0 1\n0 0 0 0\n"
    "* Can\n1\ncylinder\n0.03 0.14\n0 0 1\n0 0 0 1\n0 0 0 0\n.\n"
)
NEW_TEXT = (
    "(name)\n* Box0\n1 0 0\n0 0 0 1\n1\nbox\n0.1 0.2 0.3\n0 2 3\n0 0 0 1\n0 0 0 0\n1\nhandle\n0 0 0.1\n0 0 0 1\n.\n"
)


def test_scene_text_of_both_ages(tmp_path: Path) -> None:
    """Without and with the pose of an object, and with frames on it, which are noted."""
    (tmp_path / "a.scene").write_text(OLD_TEXT)
    read = Scene.load(str(tmp_path / "a.scene"))
    assert (read.name, read.notes) == ("noname)++", ())
    box, can = read.obstacles
    assert (box.name, box.shape, can.name, can.shape) == ("Box0", Box((0.1, 0.2, 0.3)), "Can", Cylinder(0.03, 0.14))
    np.testing.assert_allclose(box.placement[:3, 3], [1, 2, 3])
    new = parse_scene_text(NEW_TEXT, HERE)
    np.testing.assert_allclose(new.obstacles[0].placement[:3, 3], [1, 2, 3])
    assert new.notes[0].text.endswith("world.collision_objects.0.subframe_names.")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (OLD_TEXT, ""), (OLD_TEXT[40:], ""), ("box", "teapot"), ("0.2 0.3", "x"), ("0.2 0.3", "0.2"), ("1 2 3", "1 2"),
        ("1\nbox", "0\nbox"), ("1\nbox", "2\nbox"), ("Can", "Box0"), (".\n", ".\nmore\n"), ("1 2 3", "1 2 nan"),
        ("* Box0", "Box0"), ("1\nbox", "１\nbox"), ("1\nbox", 5000 * "9" + "\nbox"), ("1\nbox", "1_0\nbox"),
    ],
)  # fmt: skip
def test_broken_scene_text(old: str, new: str, tmp_path: Path) -> None:
    assert old in OLD_TEXT
    assert "a.scene" in refusal_of(lambda: parse_scene_text(OLD_TEXT.replace(old, new), tmp_path / "a.scene"))
