"""Files that once ended in a foreign exception, a crash, a hang or raw text: each is refused with one sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from planner.base.errors import RobotError
from planner.models.files.robot_files import JointChoice
from planner.models.robot import Robot, load_visuals
from planner.models.scene import Scene
from tests.refusals import refusal_of
from tests.worlds import joint_xml, link_xml

BOX = "obstacles: [{name: a, type: box, size: [1, 1, 1], MORE}]"
MOVEIT = "world: {collision_objects: [OBJECT]}"
MESH = "{id: a, mesh_poses: [{}], meshes: [{vertices: VERTICES, triangles: [{vertex_indices: INDICES}]}]}"
CORNERS = "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]"

SCENES = {
    "a position of 1e20": (BOX.replace("MORE", "position: [1.0e+20, 0, 0]"), "position.0"),
    "a base of 1e300": ("robots: {iiwa14: {base: {position: [1.0e+300, 0, 0]}}}", "base.position.0"),
    "degrees": (BOX.replace("MORE", "rpy: [0, 90, 0]"), "degrees?"),
    "5000 digits": (BOX.replace("MORE", f"position: [{'9' * 5000}, 0, 0]"), "4300 digits"),
    "no digits": (BOX.replace("MORE", "position: [0b9, 0, 0]"), "got '0b9'"),
    "an empty whole number": (BOX.replace("MORE", "position: [!!int '', 0, 0]"), "cannot make sense"),
    "a month too many": ("name: 2001-13-45", "month must be in 1..12"),
    "half a surrogate pair": ('name: "\\ud800"', "invalid Unicode"),
    "a name of 300,000 letters": (f"name: {'a' * 300_000}", "at most 1000 characters"),
    "a capsule of 1e-9": ("obstacles: [{name: a, type: capsule, radius: 0.1, length: 1.0e-9}]", "capsule.length"),
    "vertices that are no list": (MOVEIT.replace("OBJECT", MESH.replace("VERTICES", "5")), "valid list"),
    "a huge index": (
        MOVEIT.replace("OBJECT", MESH.replace("VERTICES", CORNERS).replace("INDICES", f"[0, 1, {10**25}]")),
        "triangles.0.2",
    ),
    "a quaternion of zero": (
        MOVEIT.replace("OBJECT", "{id: a, pose: {orientation: [0, 0, 0, 0]}, primitives: [], primitive_poses: []}"),
        "[0, 0, 0, 1] is no turn",
    ),
    "a matrix without enabled": (
        "world: {}\nallowed_collision_matrix: {entry_names: [a], entry_values: [{x: 1}]}",
        "list",
    ),
    "a row that is no list": ("world: {}\nallowed_collision_matrix: {entry_names: [a], entry_values: [1]}", "list"),
}


@pytest.mark.parametrize("name", SCENES)
def test_scenes(name: str, tmp_path: Path) -> None:
    text, part = SCENES[name]
    (tmp_path / "bad.yaml").write_text(text)
    assert part in refusal_of(lambda: Scene.load(str(tmp_path / "bad.yaml")))


HEAD = "n\n* a\n1\nbox\n1 1 1\n0 0 0\n0 0 0 1\n0 0 0 0\n"


@pytest.mark.parametrize("end", ["9" * 5000, "999999999", "²"])
@pytest.mark.parametrize("count", ["1", "99999999999", "1.5", "-1"])
def test_scene_texts(count: str, end: str, tmp_path: Path) -> None:
    (tmp_path / "bad.scene").write_text(HEAD.replace("\n1\n", f"\n{count}\n", 1) + end + "\n.")
    assert "export it again" in refusal_of(lambda: Scene.load(str(tmp_path / "bad.scene")))


A, B, C = (link_xml(name, '<sphere radius="0.1"/>') for name in "abc")
J = joint_xml("j", "a", "b")


# joints that follow others

_MIMIC = '<mimic joint="finger" multiplier="-2" offset="0.1"/></joint>'
_OTHER = joint_xml("other", "b", "d", "prismatic").replace("</joint>", _MIMIC)
GRIPPER = A + B + C + link_xml("d", '<sphere radius="0.1"/>') + J + joint_xml("finger", "b", "c", "prismatic") + _OTHER


def test_a_held_joint_follows_the_one_it_mimics(urdf_file: Callable[..., str]) -> None:
    path = urdf_file(GRIPPER)
    held = Robot.load(path, tool="b", fixed_joints={"finger": 0.3})
    assert held.fixed_joints == pytest.approx({"finger": 0.3, "other": -0.5})
    (body,) = [body for body in held.bodies if body.link == "d"]
    assert body.placement[2, 3] == pytest.approx(-0.5)
    assert Robot.load(path, tool="b").fixed_joints == pytest.approx({"other": 0.1})
    assert Robot.load(path, tool="b", fixed_joints={"other": 0.2}).fixed_joints == {"other": 0.2}, "as it was asked"


def test_a_mimic_joint_is_neither_planned_nor_held_by_itself(urdf_file: Callable[..., str]) -> None:
    path = urdf_file(GRIPPER)
    for tool in ("c", "d"):
        assert Robot.load(path, tool=tool).joints == ("j", "finger")
    with pytest.raises(RobotError, match="'other' mimics 'finger' and cannot be planned by itself: plan 'finger'"):
        Robot.load(path, tool="d", choice=JointChoice(joints=("j", "other")))
    with pytest.raises(RobotError, match="'other' mimics 'finger', which is planned, so it cannot be held"):
        Robot.load(path, tool="c", fixed_joints={"other": 0.0})
    nowhere = urdf_file(GRIPPER.replace('mimic joint="finger"', 'mimic joint="nobody"'))
    with pytest.raises(RobotError, match="mimics 'nobody'"):
        Robot.load(nowhere, tool="b")
    itself = urdf_file(GRIPPER.replace('mimic joint="finger"', 'mimic joint="other"'))
    with pytest.raises(RobotError, match="mimics 'other'"):
        Robot.load(itself, tool="b")


def test_visuals_that_cannot_be_read_do_not_cost_the_plan(urdf_file: Callable[..., str]) -> None:
    visual = '<visual><geometry><mesh filename="gone.stl"/></geometry></visual></link>'
    robot = Robot.load(urdf_file(A.replace("</link>", visual) + B + J))
    assert load_visuals(robot) == robot.bodies
