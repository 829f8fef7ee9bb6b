"""The ROS 2 node in one process with its users."""

import ast
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import rclpy
from rclpy.parameter import Parameter
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

import planner
from planner.base.errors import OptionError
from planner.ros.node import PARAMETERS, PlannerNode
from tests.doors.cell import (
    BOARD,
    KEPT,
    PLANAR,
    ROBOT,
    ROOT,
    START,
    Cell,
    cut,
    is_free,
    make_box,
    make_chunk,
    make_cloud,
    make_pose,
    make_state,
    play,
    read,
    turn,
    wait,
)


@pytest.fixture(scope="module")
def ros() -> Iterator[None]:
    rclpy.init()
    yield
    rclpy.try_shutdown()


@pytest.fixture(scope="module")
def opened(ros: None) -> Iterator[Cell]:
    cell = Cell("shelf_cell", robot="panda", scene="shelf", margin=0.0)
    yield cell
    cell.close()


@pytest.fixture
def cell(opened: Cell) -> Cell:
    opened.q, opened.qd = START, np.zeros(7)
    time.sleep(0.1)
    return opened


def test_a_goal_of_joints_becomes_a_motion_that_runs_when_asked(cell: Cell) -> None:
    planned = cell.ask("planner/goal_joints", make_state(ROBOT.joints, BOARD), "planned")
    assert tuple(planned.joint_names) == ROBOT.joints
    rows = play(planned, [cell.q, cell.qd])
    assert np.allclose(rows[[0, -1]], [START, BOARD])
    assert is_free(rows)
    wait(lambda: bool(cell.heard["markers"]))
    tool, arms = cell.heard["markers"][-1].markers
    assert np.allclose([tool.points[-1].x, tool.points[-1].y, tool.points[-1].z], ROBOT.fk(BOARD)[:3, 3])
    assert tool.header.frame_id == "panda_link0"
    assert len(arms.points) == 12 * 2 * 8
    before = len(cell.heard["trajectory"])
    assert cell.execute().success
    wait(lambda: len(cell.heard["trajectory"]) > before)
    assert cell.heard["trajectory"][-1] == planned
    assert "shown first" in cell.execute().message


@pytest.mark.parametrize("frame", ["world", "panda_link0", "panda_link5"])
def test_a_goal_of_the_tool_is_in_any_frame_of_the_robot(cell: Cell, frame: str) -> None:
    there = ROBOT.fk(BOARD)
    seen_from = np.linalg.inv(np.eye(4) if frame == "world" else ROBOT.fk(START, frame)) @ there
    planned = cell.ask("planner/goal_pose", make_pose(seen_from, frame), "planned")
    assert np.allclose(ROBOT.fk(read(planned)[-1][1][0]), there, atol=1e-4)


def test_a_motion_does_not_start_from_elsewhere(cell: Cell) -> None:
    cell.ask("planner/goal_joints", make_state(ROBOT.joints, BOARD), "planned")
    cell.q = START + 0.05
    time.sleep(0.1)
    answer = cell.execute()
    assert not answer.success
    assert "another position" in answer.message


@pytest.mark.parametrize("columns", [1, 2, 3])
@pytest.mark.parametrize("safe", [True, False])
def test_only_what_is_proven_goes_to_the_controller(cell: Cell, columns: int, safe: bool) -> None:
    times = 0.1 * np.arange(1, 26)
    share = np.minimum(times / 2.5, 1.0)
    blend = np.array([share**3 * (10 - 15 * share + 6 * share**2), 30 * share**2 * (1 - share) ** 2 / 2.5, 0 * share])
    blend[2] = 60 * share * (1 - share) * (1 - 2 * share) / 2.5**2
    delta = (0.1 if safe else 1.0) * (np.array([0.9, 1.2, 0.0, 0.9, 0.0, 0.0, 0.0]))
    rows = [row[:, None] * delta + (START if k == 0 else 0.0) for k, row in enumerate(blend[:columns])]
    assert is_free(np.linspace(START, rows[0][-1], 200)) == safe
    reasons = len(cell.heard["reason"])
    sent = cell.ask("planner/proposed", make_chunk(rows, times), "trajectory")
    positions = play(sent, [cell.q, cell.qd])
    assert is_free(positions)
    assert np.allclose(positions[-1], positions[-2], atol=1e-4)
    if safe:
        assert read(sent)[-1][0] <= 2.6e9
        assert np.array_equal([point.positions for point in sent.points[:25]], rows[0])
        assert len(cell.heard["reason"]) == reasons
    else:
        wait(lambda: len(cell.heard["reason"]) > reasons)
        assert "touch" in cell.heard["reason"][-1].data


def test_a_cloud_in_the_way_stops_the_motion_under_way(cell: Cell) -> None:
    times, goal = 2.0 * np.arange(1, 11), START + np.array([0.8, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    rows = START + np.linspace(0.1, 1.0, 10)[:, None] * (goal - START)
    sent = cell.ask("planner/proposed", make_chunk([rows], times), "trajectory")
    assert np.allclose(play(sent, [cell.q, cell.qd])[-1], goal, atol=0.01)
    far, near = make_box(np.array([-0.6, -0.6, 0.2])), make_box(ROBOT.fk(goal)[:3, 3])
    before = len(cell.heard["trajectory"])
    cell.send("planner/points", make_cloud(far))
    time.sleep(1.0)
    assert len(cell.heard["trajectory"]) == before
    seen_from = np.linalg.inv(ROBOT.fk(START, "panda_link0"))
    cloud = make_cloud(near @ seen_from[:3, :3].T + seen_from[:3, 3], "panda_link0")
    reason = cell.ask("planner/points", cloud, "reason")
    assert "the world changed" in reason.data
    assert "cloud of panda_link0" in reason.data
    wait(lambda: len(cell.heard["trajectory"]) > before)
    stop = cell.heard["trajectory"][-1]
    scene = planner.Scene.load("shelf")
    seen = (planner.Obstacle("seen", planner.Points(near), np.eye(4)), *scene.obstacles)
    positions = play(stop, [rows[0], (goal - START) / 20.0])
    assert is_free(positions[1:], planner.Scene(name="with the cloud", obstacles=seen))
    assert np.abs(positions[-1] - goal).max() > 0.1
    nothing = np.array([[-0.7, -0.7, 0.2]])
    for frame in ("world", "panda_link0"):
        cell.send("planner/points", make_cloud(nothing, frame))
    time.sleep(1.0)


BAD = {
    "joints of another robot": ("goal_joints", make_state("abcdefg", START), "joints of the message must include"),
    "no number": ("goal_joints", make_state(ROBOT.joints, START * np.nan), "position must be finite"),
    "a goal in contact": ("goal_joints", make_state(ROBOT.joints, 0 * START), "goal"),
    "an unknown frame": ("goal_pose", make_pose(np.eye(4), "camera"), "frame 'camera' not found.*reads no TF"),
    "no rotation": ("goal_pose", turn(2.0), "quaternion must have length 1, got 2"),
    "no points": ("proposed", make_chunk([], np.zeros(0)), "positions"),
    "half a chunk": ("proposed", make_chunk([START[None]], np.ones(1), ROBOT.joints[:3]), "joint_names must be"),
    "a short row": (
        "proposed",
        make_chunk([START[None, :5]], np.ones(1)),
        "positions of a point must have 7 values, got 5",
    ),
    "times backwards": ("proposed", make_chunk([np.tile(START, (2, 1))], np.array([2.0, 1.0])), "times must increase"),
    "NaN in a chunk": ("proposed", make_chunk([START[None] * np.nan], np.ones(1)), "positions"),
    "a damaged cloud": (
        "points",
        PointCloud2(height=1, width=4, point_step=16, row_step=64),
        "fields of a PointCloud2",
    ),
    "a cut cloud": ("points", cut(make_cloud(np.ones((4, 3)))), "data of a PointCloud2 must be"),
    "an empty cloud": ("points", make_cloud(np.full((4, 3), np.nan)), "finite point"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_gets_a_sentence_and_the_node_goes_on(cell: Cell, name: str) -> None:
    topic, message, sentence = BAD[name]
    before = len(cell.heard["trajectory"])
    reason = cell.ask(f"planner/{topic}", message, "reason").data
    assert re.search(sentence, reason)
    assert "\n" not in reason
    assert len(cell.heard["trajectory"]) == before
    cell.ask("planner/proposed", make_chunk([START[None]], np.ones(1)), "trajectory")


def test_the_robot_may_come_as_a_description(ros: None) -> None:
    cell = Cell("described", tool="link_2")
    try:
        cell.joints, cell.q, cell.qd = ("joint_1", "joint_2"), np.array([0.1, 0.2]), np.zeros(2)
        goal = make_state(cell.joints, np.array([1.0, 0.5]))
        assert "robot must come first" in cell.ask("planner/goal_joints", goal, "reason").data
        assert "URDF" in cell.ask("robot_description", String(data="<robot"), "reason", KEPT).data
        cell.send("robot_description", String(data=(PLANAR / "planar_2r.urdf").read_text()), KEPT)
        wait(lambda: cell.planner.gate is not None)
        time.sleep(0.1)
        planned = cell.ask("planner/goal_joints", goal, "planned")
        assert np.allclose(read(planned)[-1][1][0], [1.0, 0.5])
        at = planner.Robot.load("planar_2r", tool="link_2").fk([1.0, 0.5])[:3, 3]
        wait(lambda: bool(cell.heard["markers"]))
        last = cell.heard["markers"][-1].markers[0].points[-1]
        assert np.allclose([last.x, last.y, last.z], at)
    finally:
        cell.close()


def test_parameters_hold(ros: None) -> None:
    given = {"margin": 0.02, "on_unsafe": "slow", "cloud_radius": 0.03, "max_state_age": 3.0, "self_filter": 0.1}
    cell = Cell("tuned", robot="planar_2r", controller="/arm/joint_trajectory", points="camera", **given)
    try:
        sent, cell.q, cell.qd = list[JointTrajectory](), np.zeros(2), np.zeros(2)
        cell.user.create_subscription(JointTrajectory, "/arm/joint_trajectory", sent.append, 10)
        fast = make_chunk([np.array([[0.5, 0.5], [1.2, 1.2]])], np.array([0.5, 0.8]), ("joint_1", "joint_2"))
        assert "got none" in cell.ask("planner/proposed", fast, "reason").data
        cell.joints = "joint_1", "joint_2"
        time.sleep(0.2)
        assert "limit on velocity" in cell.ask("planner/proposed", fast, "reason").data
        wait(lambda: bool(sent))
        assert read(sent[0])[1][0] > 0.81e9  # slower
        assert np.allclose(read(sent[0])[1][1][0], [1.2, 1.2])
        points = np.array([[0.85, 0.08, 0.0], [0.4, 0.45, 0.0], [0.4, 0.6, 0.0]])  # the first is on the arm
        cell.send("camera", make_cloud(points))
        gate = cell.planner.gate
        assert gate is not None
        assert gate.checker.world.margin == 0.02
        wait(lambda: bool(gate.scene.obstacles))
        shapes = [item.shape for item in gate.scene.obstacles]
        assert {shape.radius for shape in shapes} == {0.03}
        assert sum(len(shape.vertices) for shape in shapes) == 2
        cell.joints = "left", "right"
        time.sleep(3.2)
        assert "at most 3 s old" in cell.ask("planner/proposed", fast, "reason").data
    finally:
        cell.close()


def start(*parameters: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "planner.ros", "--ros-args", *parameters]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("margin", -1.0, "margin must be"),
        ("margin", 1, "margin must be a number with a point"),
        ("beta", 2.0, "beta must be"),
        ("on_unsafe", "wait", "on_unsafe must be stop or slow"),
        ("scene", 3, "scene must be a text"),
    ],
)
def test_an_unusable_parameter_is_refused(ros: None, name: str, value: Any, sentence: str) -> None:
    with pytest.raises(OptionError, match=sentence):
        PlannerNode(parameter_overrides=[Parameter(name, value=value)])


def test_the_program_ends_with_a_sentence_or_by_a_signal() -> None:
    faults = {("-p", "robot:=nothing"): (3, "robot 'nothing' not found"), ("-p",): (2, "Couldn't parse")}
    processes = [start(*parameters) for parameters in faults]
    running = start("-p", "robot:=planar_2r", "-r", "__ns:=/interrupted")
    for process, (code, sentence) in zip(processes, faults.values(), strict=True):
        output, _ = process.communicate(timeout=120)
        assert process.returncode == code
        assert "Traceback" not in output
        assert sentence in output.splitlines()[-1]
    assert running.stdout is not None
    lines = iter(running.stdout.readline, "")
    assert any("ready" in line for line in lines)
    running.send_signal(signal.SIGINT)
    rest = list(lines)
    assert (running.wait(20), rest) == (0, [])


def test_the_how_to_lists_every_parameter_with_its_default() -> None:
    rows = [
        line.split("|")[1:4] for line in (ROOT / "docs" / "howto" / "ros2.md").read_text().splitlines() if "|" in line
    ]
    listed = {name.strip(" `"): row[1].strip(" `") for row in rows for name in row[0].split(",")}
    topics = ("joint_states", "points", "controller")
    assert {name: str(default) for name, (default, _) in PARAMETERS.items() if name not in topics} == {
        name: listed[name] for name in PARAMETERS if name not in topics
    }
    assert set(topics) <= set(listed)


def test_the_launch_file_names_parameters_and_topics_of_the_node() -> None:
    text = (ROOT / "docs" / "howto" / "planner.launch.py").read_text()
    compile(text, "planner.launch.py", "exec")
    given = next(node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Dict))
    assert {key.value for key in given.keys if isinstance(key, ast.Constant)} <= set(PARAMETERS)
