"""Xacro files as robots; what is there without the package that expands them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from planner.base.errors import InstallationError, RobotError
from planner.models.files.xacro import read_xml
from planner.models.robot import Robot
from tests.worlds import joint_xml, link_xml

BALL = '<xacro:macro name="ball" params="name"><link name="${name}"><collision><geometry><sphere radius="${r / 2}"/>'
BALL += "</geometry></collision></link></xacro:macro>"


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    text = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="size" default="0.1"/>'
    text += f'<xacro:property name="r" value="$(arg size)"/>{BALL}{link_xml("a")}<xacro:ball name="b"/>'
    (tmp_path / "arm.urdf.xacro").write_text(text + joint_xml("j", "a", "b") + "</robot>")
    return tmp_path / "arm.urdf.xacro"


def test_without_the_package_the_command_that_helps(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacrodoc", None)
    with pytest.raises(InstallationError, match=r"pip install 'gabf-planner\[xacro\]'"):
        Robot.load(str(arm))


def test_other_files_are_read_as_they_are(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text("<robot/>")
    assert read_xml(tmp_path / "a.urdf", "URDF") == "<robot/>"


def test_a_xacro_file_is_expanded_with_its_arguments(arm: Path) -> None:
    pytest.importorskip("xacrodoc")
    assert [vars(body.shape) for body in Robot.load(str(arm)).bodies] == [{"radius": 0.05}]
    (arm.parent / "robot.yaml").write_text("urdf: {file: arm.urdf.xacro, args: {size: '0.3'}}\n")
    assert [vars(body.shape) for body in Robot.load(str(arm.parent)).bodies] == [{"radius": 0.15}]


def test_xacro_that_nobody_expands_is_refused(arm: Path) -> None:
    with pytest.raises(RobotError, match=r"holds elements of xacro.*: call it arm.urdf.xacro"):
        Robot.load(str(arm.rename(arm.with_suffix(""))))


def test_a_xacro_file_that_cannot_be_expanded(arm: Path) -> None:
    pytest.importorskip("xacrodoc")
    arm.write_text(arm.read_text().replace("$(arg size)", "$(arg nothing)"))
    with pytest.raises(RobotError, match=r"cannot be expanded .*nothing.*args"):
        Robot.load(str(arm))
