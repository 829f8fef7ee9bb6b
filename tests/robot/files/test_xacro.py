"""Xacro files as robots."""

import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from planner.kinematics.forward import tool_positions
from planner.robot.files.packages import read_root
from planner.robot.robot import Robot
from tests.worlds import joint_xml, link_xml

BALL = '<xacro:macro name="ball" params="name"><link name="${name}"><collision><geometry><sphere radius="${r / 2}"/>'
BALL += "</geometry></collision></link></xacro:macro>"


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    text = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="size" default="0.1"/>'
    text += f'<xacro:property name="r" value="$(arg size)"/>{BALL}{link_xml("a")}<xacro:ball name="b"/>'
    (tmp_path / "arm.urdf.xacro").write_text(text + joint_xml("j", "a", "b") + "</robot>")
    return tmp_path / "arm.urdf.xacro"


def test_a_xacro_file_is_expanded_with_its_arguments(arm: Path) -> None:
    pytest.importorskip("xacro")
    assert [vars(body.shape) for body in Robot.load(str(arm)).bodies] == [{"radius": 0.05}]
    (arm.parent / "robot.yaml").write_text("urdf: {file: arm.urdf.xacro, args: {size: '0.3'}}\n")
    assert [vars(body.shape) for body in Robot.load(str(arm.parent)).bodies] == [{"radius": 0.15}]


HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="arm">'
CELL = {  # by file; each include is relative to the file that names it, as is load_yaml
    "arm.urdf.xacro": HEAD
    + """<xacro:arg name="tip" default="0.3"/><xacro:include filename="parts/column.xacro"/><xacro:column/>
      <xacro:property name="sizes" value="${xacro.load_yaml('sizes.yaml')}"/>"""
    + joint_xml("j", "column", "fore", xyz="0 0 ${sizes['length']}")
    + '<xacro:include filename="DIRNAME/parts/fore.xacro"/></robot>',
    "sizes.yaml": "length: 0.25",
    "parts/column.xacro": HEAD + '<xacro:include filename="deep/link.xacro"/><xacro:macro name="column">'
    '<xacro:thing name="column"/></xacro:macro></robot>',
    "parts/deep/link.xacro": HEAD + '<xacro:macro name="thing" params="name"><link name="${name}"><collision><geometry>'
    '<sphere radius="0.01"/></geometry></collision></link></xacro:macro></robot>',
    "parts/fore.xacro": f'{HEAD}<xacro:thing name="fore"/>{link_xml("hand")}'
    + joint_xml("weld", "fore", "hand", "fixed", xyz="0 0 $(arg tip)")
    + "</robot>",
}


def cell(folder: Path, dirname: str) -> Path:
    for name, text in CELL.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text.replace("DIRNAME", dirname))
    return folder / "arm.urdf.xacro"


@pytest.mark.parametrize("dirname", ["$(find cell)", "."])
def test_files_that_a_xacro_names_do_not_depend_on_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dirname: str
) -> None:
    pytest.importorskip("xacro")
    path = cell(tmp_path / "cell", dirname)
    cell(tmp_path / "other", ".")
    (tmp_path / "other" / "sizes.yaml").write_text("length: 9")
    for folder in ("cell", "other", "."):
        monkeypatch.chdir(tmp_path / folder)
        for name in (path, Path(os.path.relpath(path))):
            np.testing.assert_allclose(tool_positions(Robot.load(name), np.zeros((1, 1))), [[0, 0, 0.55]])


def test_a_xacro_becomes_the_urdf_that_the_program_xacro_makes(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    path = cell(tmp_path, ".")
    program = [sys.executable, "-c", "import xacro; xacro.main()", str(path), "tip:=0.7"]
    made = subprocess.run(program, capture_output=True, text=True, check=True, cwd="/").stdout
    ours = ET.tostring(read_root(path, "URDF", {"tip": "0.7"}), encoding="unicode")
    assert ET.canonicalize(made, strip_text=True) == ET.canonicalize(ours, strip_text=True)
