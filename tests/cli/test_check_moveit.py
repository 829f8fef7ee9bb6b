"""The four faults of docs/howto/check_moveit.md: each file gets its finding, number and exit code, in a bag too."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.interpolate import BPoly

from planner.collision.__init__ import make_checker
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.trajectory.recorded import read_motion
from tests.command_line import Run
from tests.documents import ROOT

MOVEIT = ROOT / "scenes/examples/moveit"
SCENE = str(ROOT / "scenes/examples/scene0001.yaml")
LINE = "=" * 80 + "\nMSG: "
TIMED = f"""std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint[] points
{LINE}std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}builtin_interfaces/Time
int32 sec
uint32 nanosec
{LINE}builtin_interfaces/Duration
int32 sec
uint32 nanosec
{LINE}trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
"""
SEVERAL = f"""{LINE}trajectory_msgs/MultiDOFJointTrajectory
std_msgs/Header header
string[] joint_names
"""
JOINTS = f"{LINE}trajectory_msgs/JointTrajectory\n{TIMED}{SEVERAL}"
ROBOT = "trajectory_msgs/JointTrajectory joint_trajectory\n"
ROBOT += "trajectory_msgs/MultiDOFJointTrajectory multi_dof_joint_trajectory\n"
DISPLAY = (
    f"string model_id\nmoveit_msgs/RobotTrajectory[] trajectory\nmoveit_msgs/RobotState trajectory_start\n{JOINTS}"
)
DISPLAY += (
    f"{LINE}moveit_msgs/RobotTrajectory\n{ROBOT}{LINE}moveit_msgs/RobotState\nsensor_msgs/JointState joint_state\n"
)
DISPLAY += f"bool is_diff\n{LINE}sensor_msgs/JointState\nstring[] name\nfloat64[] position\n"
MESSAGES = {  # fields that the reader ignores are left out
    "trajectory_msgs/msg/JointTrajectory": TIMED,
    "moveit_msgs/msg/RobotTrajectory": ROBOT + JOINTS,
    "moveit_msgs/msg/DisplayTrajectory": DISPLAY,
}
Judged = tuple[str, tuple[str, ...], float | None, float, str]
FAULTS: dict[
    str, tuple[str, Judged]
] = {  # the type of message, and kind, subject, value, bound and words of the finding
    "collides": (
        "moveit_msgs/msg/DisplayTrajectory",
        ("contact", ("panda_rightfinger", "post"), 0.0, 0.0, "'panda_rightfinger' and 'post' touch at 2."),
    ),
    "too-much-acceleration": (
        "moveit_msgs/msg/RobotTrajectory",
        ("limit", ("acceleration", "panda_joint1"), 10.3241, 3.75, "175 % over its limit of 3.75"),
    ),
    "too-fast": (
        "trajectory_msgs/msg/JointTrajectory",
        ("limit", ("velocity", "panda_joint1"), 2.3925, 2.175, "10 % over its limit of 2.175"),
    ),
    "ends-moving": (
        "moveit_msgs/msg/RobotTrajectory",
        ("discontinuity", ("velocity", "panda_joint1"), 5.2e-5, 0.0, "the last velocity is not 0"),
    ),
}


def write_mcap(path: Path, kind: str, message: Any) -> None:
    """Write the message as a node of ROS 2 records it, with a /tf before it, which is none of ours."""
    library, file = pytest.importorskip("mcap_ros2.writer"), io.BytesIO()
    writer = library.Writer(file)
    other = writer.register_msgdef("std_msgs/msg/String", "string data")
    writer.write_message("/other", other, {"data": "first"}, log_time=0, publish_time=0)
    schema = writer.register_msgdef(kind, MESSAGES[kind])
    writer.write_message("/display_planned_path", schema, message, log_time=1, publish_time=1)
    writer.finish()
    path.write_bytes(file.getvalue())


def judge(run: Run, path: Path, scene: str = SCENE) -> tuple[int, dict[str, Any]]:
    limits = ("--limits", str(MOVEIT / "joint-limits.yaml"))
    code, out, err = run("check", str(path), "--robot", "panda", "--scene", scene, *limits, "--json")
    assert err == ""
    return code, json.loads(out)


def assert_judged(result: tuple[int, dict[str, Any]], judged: Judged) -> None:
    kind, what, value, allowed, words = judged
    code, report = result
    assert code == 4
    (finding,) = report["findings"]
    assert (finding["kind"], tuple(finding["what"]), finding["allowed"]) == (kind, what, pytest.approx(allowed))
    assert finding["value"] == pytest.approx(value, abs=1e-9)
    assert words in finding["sentence"]


@pytest.mark.parametrize("name", FAULTS)
@pytest.mark.parametrize("ending", ["yaml", "mcap"])
def test_a_reported_fault_is_found(name: str, ending: str, run: Run, tmp_path: Path) -> None:
    kind, judged = FAULTS[name]
    path = MOVEIT / f"{name}.yaml"
    if ending == "mcap":
        write_mcap(tmp_path / "bag.mcap", kind, yaml.safe_load(path.read_text()))
        path = tmp_path / "bag.mcap"
    assert_judged(judge(run, path, SCENE if name == "collides" else "empty"), judged)


def test_the_motion_that_collides_is_free_at_every_point_and_touches_between_two() -> None:
    """Looked at on scipy's quintics."""
    robot = Robot.load("panda")
    checker = make_checker(robot, Scene.load(SCENE))
    message = yaml.safe_load((MOVEIT / "collides.yaml").read_text())["trajectory"][0]["joint_trajectory"]
    points = message["points"]
    times = [point["time_from_start"]["sec"] + 1e-9 * point["time_from_start"]["nanosec"] for point in points]
    assert tuple(message["joint_names"]) == robot.joints
    assert all(checker.first_contact(np.array(point["positions"])) is None for point in points)
    rows = [[point[key] for key in ("positions", "velocities", "accelerations")] for point in points]
    curve = BPoly.from_derivatives(times, np.array(rows))
    looks = np.arange(0.0, times[-1], 0.002)
    touching = looks[[checker.first_contact(q) is not None for q in curve(looks)]]
    assert touching.size
    assert 0.02 < np.ptp(touching) < 1.0, "a collision that a sparse look misses"
    assert read_motion(MOVEIT / "collides.yaml", robot).notes == (  # type: ignore[union-attr]
        "trajectory_start of the message are not checked",
    )


def test_a_response_of_a_planner_is_read_and_its_success_is_no_proof(run: Run, tmp_path: Path) -> None:
    """A MotionPlanResponse with MoveIt's code of success."""
    inner = yaml.safe_load((MOVEIT / "collides.yaml").read_text())["trajectory"][0]
    whole = {"trajectory_start": {}, "group_name": "panda_arm", "trajectory": inner, "planning_time": 0.1}
    path = tmp_path / "response.yaml"
    path.write_text(yaml.safe_dump(whole | {"error_code": {"val": 1, "message": "", "source": ""}}))
    assert_judged(judge(run, path), FAULTS["collides"][1])


def test_the_same_motion_without_the_fault_is_usable(run: Run, tmp_path: Path) -> None:
    """So each file has one fault only."""
    for name, wrapper in (("too-much-acceleration", "joint_trajectory"), ("too-fast", None)):
        data = yaml.safe_load((MOVEIT / f"{name}.yaml").read_text())
        for point in (data[wrapper] if wrapper else data)["points"]:
            clock = point["time_from_start"]
            nanoseconds = 2 * (clock["sec"] * 10**9 + clock["nanosec"])  # twice as slow
            point["time_from_start"] = {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}
            point["velocities"] = [value / 2 for value in point["velocities"]]
            point["accelerations"] = [value / 4 for value in point["accelerations"]]
        (tmp_path / "slow.yaml").write_text(yaml.safe_dump(data))
        code, report = judge(run, tmp_path / "slow.yaml", "empty")
        assert (code, report["findings"]) == (0, [])
    data = yaml.safe_load((MOVEIT / "ends-moving.yaml").read_text())
    data["joint_trajectory"]["points"][-1]["velocities"][0] = 0.0
    (tmp_path / "rests.yaml").write_text(yaml.safe_dump(data))
    assert judge(run, tmp_path / "rests.yaml", "empty")[0] == 0
    assert judge(run, MOVEIT / "collides.yaml", "empty")[0] == 0


def test_a_bag_without_a_trajectory_names_what_is_read(run: Run, tmp_path: Path) -> None:
    library, file = pytest.importorskip("mcap_ros2.writer"), io.BytesIO()
    writer = library.Writer(file)
    schema = writer.register_msgdef("std_msgs/msg/String", "string data")
    writer.write_message("/other", schema, {"data": "first"}, log_time=0, publish_time=0)
    writer.finish()
    (tmp_path / "bag.mcap").write_bytes(file.getvalue())
    code, _, err = run("check", str(tmp_path / "bag.mcap"), "--robot", "panda", "--scene", "empty")
    assert code == 3
    assert "moveit_msgs/msg/DisplayTrajectory not found: record one." in " ".join(err.split())
