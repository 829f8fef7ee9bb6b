"""A robot's files: which joints are planned, what holds the others, and the old key."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from planner.base.errors import RobotError
from planner.robot.files.robot_files import ALL_JOINTS, JointChoice, read_robot
from tests.worlds import joint_xml, link_xml


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """Three joints, the last one held by the robot file, which still speaks of ``rows``."""
    links = "".join(link_xml(name, '<sphere radius="0.01"/>') for name in "abcd")
    joints = joint_xml("j1", "a", "b") + joint_xml("j2", "b", "c", xyz="1 0 0") + joint_xml("j3", "c", "d", xyz="1 0 0")
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>')
    (tmp_path / "robot.yaml").write_text(
        "name: mine\nurdf: {file: arm.urdf}\ntool: d\nrows: planar\nfixed_joints: {j3: 0.2}\n"
    )
    return tmp_path / "robot.yaml"


def test_held_joints_are_not_planned(arm: Path) -> None:
    files = read_robot(str(arm), None)
    assert files.name == "mine"
    assert files.planned_joints(None, ALL_JOINTS, {}) == ["j1", "j2"]
    assert files.planned_joints(None, ALL_JOINTS, {"j1": 0.0}) == ["j2"]
    assert files.planned_joints("c", JointChoice(joints=("j2",)), {}) == ["j2"]
    with pytest.raises(RobotError, match="j3"):
        files.planned_joints(None, JointChoice(joints=("j2", "j3")), {})
    with pytest.raises(RobotError, match="j9"):
        files.planned_joints(None, JointChoice(joints=("j9",)), {})


def test_the_old_key_is_read_with_a_note(arm: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        files = read_robot(str(arm), None)
    assert files.file is not None
    assert files.file.manipulability == "planar"
    assert "'manipulability' now: rename it" in caplog.text


def test_every_file_is_read_once(arm: Path) -> None:
    files = read_robot(str(arm), None)
    for path in arm.parent.iterdir():
        path.unlink()
    assert files.model.names[1:].tolist() == ["j1", "j2", "j3"]


def test_a_file_of_another_kind_is_not_called_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.txt").write_text("")
    with pytest.raises(RobotError, match=r"arm\.txt ends neither in \.urdf nor in \.yaml: rename it"):
        read_robot("arm.txt")
