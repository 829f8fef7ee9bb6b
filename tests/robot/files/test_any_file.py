"""Any change of a file gives a robot or scene, or one sentence: scenes, robot files, URDF, SRDF and MJCF."""

import contextlib
import copy
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planner.base.errors import PlannerError
from planner.robot.robot import Robot, with_carried
from planner.robot.scene import Scene
from tests.robot.files.test_mjcf import ARM as MJCF
from tests.robot.files.test_srdf import SRDF
from tests.worlds import joint_xml, link_xml

MANY = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
SCENE = """
name: cell
obstacles:
  - {name: board, type: box, size: [0.8, 0.3, 0.02], position: [0.5, 0, 0.6], rpy: [0, 0, 1]}
  - {name: post, type: cylinder, radius: 0.03, length: 1.0, quaternion: [0, 0, 0, 1], speed_limit: 0.1}
  - {name: ball, type: sphere, radius: 0.1, motion: [{t: 0, position: [1, 0, 0]}, {t: 2, position: [2, 0, 0]}]}
carried: [{name: bar, type: capsule, radius: 0.02, length: 0.5, link: link_2, touch_links: [link_1]}]
states: {planar_2r: {start: "q:0,0"}}
robots: {planar_2r: {base: {position: [0, 0, 1]}, tool: tool, fixed_joints: {}}}
allowed: [[board, link_1]]
constraints: ["axis:z,0,0,1,0.1"]
"""
ROBOT = """
name: mine
urdf: {file: arm.urdf}
srdf: {file: arm.srdf}
joints: [shoulder, elbow]
tool: hand
home: [0.1, 0.2]
manipulability: planar
fixed_joints: {lift: 0.1}
disabled_pairs: [[base, column]]
motion: {acceleration: [1, 2], jerk: 5, source: me}
"""
BOX = '<box size="0.1 0.1 0.1"/>'
URDF = f'<robot name="arm">{"".join(link_xml(name, BOX) for name in ("base", "column", "upper", "fore"))}' + (
    link_xml("hand") + joint_xml("lift", "base", "column", "prismatic", limit="0 1")
    + joint_xml("shoulder", "column", "upper", xyz="0 0 0.3") + joint_xml("elbow", "upper", "fore", xyz="0.4 0 0")
    + joint_xml("weld", "fore", "hand", "fixed", xyz="0.3 0 0") + "</robot>"
)  # fmt: skip
JUNK = st.sampled_from(
    [None, True, 0, -1, 1e9, float("nan"), float("inf"), "", "x", "base", "elbow", [], [1, 2, 3], {}, {"a": 1}]
)
WORDS = st.sampled_from(["", "x", "nan", "-1", "0", "1e300", "0 0 0", "1 2 3", "base", "elbow", "fixed", "planar", "é"])


def places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Every holder in plain data, with each of its keys."""
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from places(value[key])


def damaged_data(draw: st.DrawFn, data: Any) -> Any:
    """Plain data with a value changed, lost, or under another key."""
    data = copy.deepcopy(data)
    for _ in range(draw(st.integers(1, 2))):
        holder, key = draw(st.sampled_from(list(places(data))))
        change = draw(st.sampled_from(["junk", "junk", "lose", "rename"]))
        if change == "junk":
            holder[key] = copy.deepcopy(draw(JUNK))
        else:
            value = holder.pop(key)
            if change == "rename" and isinstance(holder, dict):
                holder[f"{key}x"] = value
        if not list(places(data)):
            break
    return data


def damaged_xml(draw: st.DrawFn, text: str) -> str:
    """XML with an attribute changed or lost, or an element lost, doubled, moved or under another name."""
    root = ET.fromstring(text)
    for _ in range(draw(st.integers(1, 2))):
        element = draw(st.sampled_from(list(root.iter())))
        change = draw(st.sampled_from(["value", "value", "lose", "rename", "drop", "double", "move"]))
        if element.attrib and change in ("value", "lose"):
            key = draw(st.sampled_from(sorted(element.attrib)))
            element.set(key, draw(WORDS)) if change == "value" else element.attrib.pop(key)
        elif change == "rename" and element is not root:
            element.tag += "x"
        elif len(element) and change in ("drop", "double", "move"):
            child = element[draw(st.integers(0, len(element) - 1))]
            element.remove(child) if change != "double" else None
            element.append(copy.deepcopy(child)) if change == "double" else None
            root.append(child) if change == "move" else None
    return ET.tostring(root, encoding="unicode")


@st.composite
def cells(draw: st.DrawFn) -> dict[str, str]:
    """The files of a robot and a scene, one of them damaged."""
    files = {"arm.urdf": URDF, "arm.srdf": SRDF, "robot.yaml": ROBOT, "scene.yaml": SCENE}
    name = draw(st.sampled_from(sorted(files)))
    if name.endswith(".yaml"):
        return files | {name: yaml.safe_dump(damaged_data(draw, yaml.safe_load(files[name])))}
    return files | {name: damaged_xml(draw, files[name])}


@contextlib.contextmanager
def one_sentence() -> Iterator[None]:
    try:
        yield
    except PlannerError as error:
        text = str(error)
        assert text.endswith(".")
        assert "\n" not in text
        assert len(text) < 1000
        assert error.exit_code == 3  # noqa: PT017 (no error is right too)


@MANY
@given(cells())
def test_files_give_a_robot_and_a_scene_or_one_sentence(files: dict[str, str]) -> None:
    with TemporaryDirectory() as folder:
        for name, text in files.items():
            Path(folder, name).write_text(text)
        with one_sentence():
            scene = Scene.load(f"{folder}/scene.yaml")
            for item in (*scene.obstacles, *scene.carried):
                assert np.isfinite(item.placement).all()
            with_carried(Robot.load("planar_2r"), scene.carried)
        with one_sentence():
            robot = Robot.load(f"{folder}/robot.yaml")
            assert np.isfinite([robot.lower, robot.upper, robot.home]).all()
            assert (robot.lower < robot.upper).all()
            assert robot.bodies


@st.composite
def models(draw: st.DrawFn) -> str:
    return damaged_xml(draw, MJCF.replace("EXTRA", ""))


@MANY
@given(models())
def test_an_mjcf_gives_a_robot_or_one_sentence(text: str) -> None:
    with TemporaryDirectory() as folder:
        Path(folder, "arm.xml").write_text(text)
        with one_sentence():
            assert Robot.load(f"{folder}/arm.xml").dof


@pytest.mark.parametrize("text", [SCENE, ROBOT])
def test_the_files_are_sound_before_they_are_damaged(text: str, tmp_path: Path) -> None:
    for name, each in (("arm.urdf", URDF), ("arm.srdf", SRDF), ("robot.yaml", text), ("scene.yaml", text)):
        (tmp_path / name).write_text(each)
    assert Scene.load(tmp_path / "scene.yaml").carried if text == SCENE else Robot.load(tmp_path / "robot.yaml").dof
