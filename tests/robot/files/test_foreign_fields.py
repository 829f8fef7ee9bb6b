"""Fields of foreign files that were once dropped, or read as something else: each is honoured, noted or refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planner.base.words import number
from planner.base.yamlfile import parse_yaml
from planner.kinematics.forward import Chain, joint_placements, tool_positions
from planner.problem.request import LimitsRequest
from planner.robot.files.robot_files import JointChoice
from planner.robot.files.urdf import Mimic
from planner.robot.model_checks import notes
from planner.robot.robot import Robot, with_carried, with_tool
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Sphere
from planner.trajectory.limits import MotionLimits
from planner.trajectory.messages import points_of
from planner.trajectory.path_file import read_joint_path
from tests.refusals import refusal_of
from tests.worlds import joint_xml, link_xml, load

CHAIN = "".join(map(link_xml, ("base", "upper", "fore", "flange", "tcp"))) + (
    joint_xml("turn", "base", "upper", xyz="0 0 0.5") + joint_xml("bend", "upper", "fore", axis="0 1 0", xyz="0 0 0.5")
)
TCP = '<joint name="hold" type="fixed"><parent link="flange"/><child link="tcp"/><origin xyz="0 0 0.3"/></joint>'


def follows(leader: str = "bend") -> str:
    joint = joint_xml("follow", "fore", "flange", axis="0 1 0", xyz="0 0 0.2")
    return CHAIN + joint.replace("</joint>", f'<mimic joint="{leader}"/></joint>') + TCP


def test_a_mimic_joint_moves_tools_and_what_is_held(urdf_file: Callable[..., str]) -> None:
    """Nothing that collides hangs on it: it was held where it is 0."""
    path, planned = urdf_file(follows()), JointChoice(joints=("turn", "bend"))
    q = np.array([[0.3, 0.4]])
    there = [0.2 * np.sin(0.4) + 0.3 * np.sin(0.8), 0.0, 1.0 + 0.2 * np.cos(0.4) + 0.3 * np.cos(0.8)]
    turned = [np.cos(0.3) * there[0], np.sin(0.3) * there[0], there[2]]
    robot = Robot.load(path, tool="fore", choice=planned)
    for moved in (Robot.load(path, tool="tcp", choice=planned), Robot.load(path, tool="tcp"), with_tool(robot, "tcp")):
        assert moved.joints == ("turn", "bend")
        np.testing.assert_allclose(tool_positions(moved, q)[0], turned, atol=1e-15)
    holding = with_carried(robot, [Carried("tcp", "cup", Sphere(0.03), np.eye(4))])
    rotation, position = joint_placements(Chain.of(holding), q)
    (cup,) = holding.carried
    at = position[cup.joint, 0] + rotation[cup.joint, 0] @ cup.placement[:3, 3]
    np.testing.assert_allclose(at, turned, atol=1e-15)
    assert "'follow' mimics 'bend', which is planned, so it cannot be held" in refusal_of(
        lambda: Robot.load(path, tool="tcp", choice=planned, fixed_joints={"follow": 0.0})
    )
    led = Robot.load(path, tool="tcp", choice=JointChoice(joints=("turn",)), fixed_joints={"bend": 0.5})
    assert led.fixed_joints == {"bend": 0.5, "follow": 0.5}


def test_a_mimic_joint_of_a_mimic_joint_follows_its_leader(urdf_file: Callable[..., str]) -> None:
    says = '<mimic joint="follow" multiplier="-0.5" offset="0.25"/></joint>'
    second = joint_xml("second", "base", "last").replace("</joint>", says)
    path = urdf_file(follows() + link_xml("last", '<sphere radius="0.1"/>') + second)
    robot = Robot.load(path, tool="fore", choice=JointChoice(joints=("turn", "bend")))
    assert robot.followers == (Mimic("follow", "bend", 1.0, 0.0), Mimic("second", "bend", -0.5, 0.25))
    held = Robot.load(path, tool="upper", fixed_joints={"bend": 0.5})
    assert held.fixed_joints == {"bend": 0.5, "follow": 0.5}, "and the second is at 0"
    Path(path).write_text(Path(path).read_text().replace('<mimic joint="bend"/>', '<mimic joint="second"/>'))
    assert "joint 'follow'" in (text := refusal_of(lambda: Robot.load(path, tool="fore")))
    assert "their leaders form a circle" in text


def test_contacts_allowed_to_names_that_nobody_has_are_noted(tmp_path: Path) -> None:
    robot, matrix = load("planar_2r"), "entry_names: [link1, gripper, <octomap>], entry_values: "
    rows = "[[false, true, true], [true, false, true], [true, true, false]]"
    (tmp_path / "scene.yaml").write_text(f"world: {{}}\nallowed_collision_matrix: {{{matrix}{rows}}}\n")
    scene = Scene.load(tmp_path / "scene.yaml")
    (note,) = [note for note in notes(robot, scene) if "neither it nor the robot has" in note.text]
    assert "contacts of gripper," in note.text
    assert not note.grave


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("has_position_limits: true, max_position: 9", "it has_position_limits and no min_position"),
        ("has_soft_limits: true, soft_lower_limit: -9", "it has_soft_limits and no soft_upper_limit"),
        ("k_velocity: 1, max_velocity: 0.1", "(of it gains are passed over)"),
        ("max_velocity: 0.1, min_position: -9, max_effort: 1", "(of it efforts, wider positions are passed over)"),
        ("angle_wraparound: true, max_velocity: 0.1", "(of it angle_wraparound are passed over)"),
    ],
)
def test_what_is_said_of_limits_is_taken_told_or_refused(said: str, words: str, tmp_path: Path) -> None:
    robot = load("planar_2r")
    (tmp_path / "limits.yaml").write_text(
        f"joint_limits: {{{robot.joints[0]}: {{{said}}}, {robot.joints[1]}: {{max_velocity: 0.1}}}}"
    )
    request = LimitsRequest(limits=tmp_path / "limits.yaml")
    if words.startswith("it has"):
        assert words in refusal_of(lambda: MotionLimits.of(robot, request))
    else:
        assert words in MotionLimits.of(robot, request).source["velocity"]


@pytest.mark.parametrize("word", ["0_3", "1_000", "１", "0x1"])
def test_what_only_python_calls_a_number_is_none(word: str) -> None:
    with pytest.raises(ValueError, match="could not convert"):
        number(word)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *[("010", 10), ("1:30", "1:30"), ("1_000", "1_000"), ("0o10", 8), ("0x1F", 31), ("-7", -7), ("+3", 3)],
        *[
            ("1e-3", 1e-3),
            ("1.5", 1.5),
            (".5", 0.5),
            ("1.", 1.0),
            ("-.inf", -np.inf),
            ("1.5e3", 1500.0),
            ("0b1", "0b1"),
        ],
    ],
)
def test_numbers_of_yaml_are_those_of_its_version_1_2(text: str, value: object) -> None:
    found = parse_yaml(f"x: {text}", "here")["x"]
    assert found == value
    assert type(found) is type(value)


# scenes and paths


def test_what_wraps_a_path_without_times_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "path.json"
    inner = '{"joint_names": ["joint1", "joint2"], "points": [{"positions": [0, 0]}, {"positions": [0.1, 0]}]}'
    path.write_text(f'{{"joint_trajectory": {inner}}}')
    robot = load("planar_2r")
    text = path.read_text().replace("joint1", robot.joints[0]).replace("joint2", robot.joints[1])
    path.write_text(f'{{"trajectory": [{text}], "trajectory_start": {{"joint_state": {{"name": ["x"]}}}}}}')
    assert len(read_joint_path(path, robot)) == 2
    assert "trajectory_start of the message are not checked" in caplog.text


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ('{"stamp": 12.5}', "header's stamp"),
        ('{"stmp": 1}', "its header has a key 'stmp' that is not known: did you mean 'stamp'"),
        ('"now"', "its header is 'now'; give stamp and frame_id"),
    ],
)
def test_a_header_has_a_stamp_and_a_frame(header: str, words: str) -> None:
    point = '"points": [{"positions": [0, 0], "time_from_start": 0}]'
    data = json.loads(f'{{"header": {header}, "joint_names": ["a", "b"], {point}}}')
    if words.startswith("header"):
        raw = points_of(data, "it")
        assert raw is not None
        assert any(words in note for note in raw.notes)
    else:
        assert words in refusal_of(lambda: points_of(data, "it"))
