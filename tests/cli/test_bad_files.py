"""Scenes that cannot be meant, and joints that follow others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from planner.base.errors import RobotError
from planner.robot.files.robot_files import JointChoice
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from tests.refusals import refusal_of
from tests.worlds import joint_xml, link_xml

BOX = "obstacles: [{name: a, type: box, size: [1, 1, 1], MORE}]"
MOVEIT = "world: {collision_objects: [{id: a, OBJECT}]}"
SCENES = {
    "degrees": (BOX.replace("MORE", "rpy: [0, 90, 0]"), "degrees?"),
    "no digits": (BOX.replace("MORE", "position: [0b9, 0, 0]"), "got '0b9'"),
    "a base of 1e300": ("robots: {iiwa14: {base: {position: [1.0e+300, 0, 0]}}}", "base.position.0"),
    "a quaternion of zero": (
        MOVEIT.replace("OBJECT", "pose: {orientation: [0, 0, 0, 0]}, primitives: [], primitive_poses: []"),
        "[0, 0, 0, 1] is no turn",
    ),
    "a row that is no list": ("world: {}\nallowed_collision_matrix: {entry_names: [a], entry_values: [1]}", "list"),
}


@pytest.mark.parametrize("name", SCENES)
def test_scenes(name: str, tmp_path: Path) -> None:
    text, part = SCENES[name]
    (tmp_path / "bad.yaml").write_text(text)
    assert part in refusal_of(lambda: Scene.load(str(tmp_path / "bad.yaml")))


A, B, C = (link_xml(name, '<sphere radius="0.1"/>') for name in "abc")
J = joint_xml("j", "a", "b")


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
