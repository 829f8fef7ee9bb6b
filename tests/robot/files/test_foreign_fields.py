"""Fields of foreign files that were once dropped, or read as something else: each is honoured, noted or refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import PlannerError
from planner.base.words import number
from planner.base.yamlfile import parse_yaml
from planner.kinematics.forward import Chain, joint_placements, tool_positions
from planner.problem.request import LimitsRequest
from planner.robot.files.robot_files import JointChoice
from planner.robot.files.urdf import Mimic
from planner.robot.model_checks import notes
from planner.robot.robot import Robot, with_carried, with_tool
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Obstacle, Sphere
from planner.trajectory.limits import MotionLimits
from planner.trajectory.messages import points_of
from planner.trajectory.points import read_motion
from tests.refusals import refusal_of
from tests.worlds import joint_xml, link_xml, load

LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
CHAIN = "".join(map(link_xml, ("base", "upper", "fore", "flange", "tcp"))) + (
    joint_xml("turn", "base", "upper", xyz="0 0 0.5") + joint_xml("bend", "upper", "fore", axis="0 1 0", xyz="0 0 0.5")
)
TCP = '<joint name="hold" type="fixed"><parent link="flange"/><child link="tcp"/><origin xyz="0 0 0.3"/></joint>'

TCP_FIXED = TCP + '<joint name="on" type="fixed"><parent link="fore"/><child link="flange"/></joint>'


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


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ('soft_upper_limit="0.5"', "soft limits of '0.5': give both"),
        ('soft_lower_limit="0.5" soft_upper_limit="-0.5"', "soft limits of '0.5' and '-0.5': give both"),
        ('soft_lower_limit="0.5" soft_upper_limit="0.5"', "give both"),
    ],
)
def test_half_a_safety_controller_is_refused(urdf_file: Callable[..., str], said: str, words: str) -> None:
    path = urdf_file(CHAIN.replace(LIMIT, f"{LIMIT}<safety_controller {said} k_velocity='1'/>", 1) + TCP_FIXED)
    assert words in refusal_of(lambda: Robot.load(path, tool="fore"))


def test_limits_that_are_not_followed_are_noted(urdf_file: Callable[..., str]) -> None:
    quick = LIMIT.replace("effort", 'acceleration="0.5" jerk="3" effort')
    path = urdf_file("".join(map(link_xml, "abc")) + joint_xml("j", "a", "b") + joint_xml("k", "b", "c"), version="1.2")
    text = Path(path).read_text().replace(LIMIT, quick, 1)
    Path(path).write_text(text.replace('name="k" type="revolute"', 'name="k" type="continuous"'))
    notes = Robot.load(path).notes
    assert [note.grave for note in notes] == [True, False]
    assert "limits on acceleration, jerk in the URDF are not followed" in notes[0].text
    assert "lower and upper of k are not followed" in notes[1].text


def test_contacts_allowed_to_names_that_nobody_has_are_noted(tmp_path: Path) -> None:
    robot, matrix = load("planar_2r"), "entry_names: [link1, gripper, <octomap>], entry_values: "
    rows = "[[false, true, true], [true, false, true], [true, true, false]]"
    (tmp_path / "scene.yaml").write_text(f"world: {{}}\nallowed_collision_matrix: {{{matrix}{rows}}}\n")
    scene = Scene.load(tmp_path / "scene.yaml")
    (note,) = [note for note in notes(robot, scene) if "neither it nor the robot has" in note.text]
    assert "contacts of gripper," in note.text
    assert not note.grave


def test_obstacles_that_may_touch_each_other_are_noted() -> None:
    robot, two = load("planar_2r"), [Obstacle(name, Sphere(0.1), np.eye(4)) for name in "ab"]
    scene = Scene("x", tuple(two), allowed=frozenset({frozenset("ab"), frozenset({"a", "link_1"})}))
    (note,) = [note for note in notes(robot, scene) if "each other" in note.text]
    assert note.text.endswith("which nothing asks about: a and b.")


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
    assert len(read_motion(path, robot)) == 2
    assert "trajectory_start of the message are not checked" in caplog.text


def test_args_for_what_is_no_xacro_are_refused(tmp_path: Path, urdf_file: Callable[..., str]) -> None:
    urdf = urdf_file("".join(map(link_xml, "ab")) + joint_xml("j", "a", "b"))
    (tmp_path / "robot.yaml").write_text(f"name: arm\nurdf: {{file: {urdf}, args: {{long: '1'}}}}\ntool: b\n")
    with pytest.raises(PlannerError, match="is no xacro, and would not look at args"):
        Robot.load(tmp_path / "robot.yaml")


def test_args_that_a_xacro_does_not_have_are_refused(tmp_path: Path, urdf_file: Callable[..., str]) -> None:
    pytest.importorskip("xacro")
    urdf = Path(urdf_file("".join(map(link_xml, "ab")) + joint_xml("j", "a", "b")))
    declared = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="arm"><xacro:arg name="prefix"'
    text = urdf.read_text()
    head = text[text.index("<robot") : text.index(">", text.index("<robot")) + 1]
    (tmp_path / "arm.urdf.xacro").write_text(text.replace(head, f'{declared} default=""/>'))
    for name, fits in (("prefix", True), ("prefx", False)):
        (tmp_path / "robot.yaml").write_text(f"urdf: {{file: arm.urdf.xacro, args: {{{name}: left_}}}}\ntool: b\n")
        if fits:
            assert Robot.load(tmp_path / "robot.yaml").name == "arm"
        else:
            message = refusal_of(lambda: Robot.load(tmp_path / "robot.yaml"))
            assert "has no argument 'prefx' (did you mean 'prefix'?); it has prefix" in message


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
