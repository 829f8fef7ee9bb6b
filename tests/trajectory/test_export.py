"""Exports read back: what a controller interpolates between their points is what was proven, in every format."""

import json
import sys
from contextlib import nullcontext
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any, get_args
from unittest.mock import MagicMock, Mock

import numpy as np
import pytest
import yaml

from planner.base.errors import PlannerError
from planner.collision import make_checker
from planner.robot.poses import pose
from planner.robot.shapes import Box
from planner.trajectory.export import SENDER, SUFFIX, Format, export
from planner.trajectory.recorded import read_motion
from planner.trajectory.timing import time_path
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load, scene_of

ARM = load("planar_2r")
A, B = ARM.joints
PATH = np.array([[-1.0, 0.5], [0.0, 1.0], [1.0, 0.5], [1.2, -0.5]])
FAR = scene_of((Box((0.1, 0.1, 0.1)), pose([5.0, 0.0, 0.0])))
MADE = time_path(PATH, make_checker(ARM, FAR), time_law="shortcuts")
needs_mcap = pytest.mark.skipif(find_spec("mcap") is None, reason="the extra mcap is not installed")
FORMATS = [pytest.param(kind, marks=needs_mcap) if kind == "mcap" else kind for kind in get_args(Format)]


def read_back(content: bytes, kind: Format, folder: Path) -> Trajectory:
    path = folder / f"back.{SUFFIX[kind]}"
    path.write_bytes(content)
    found = read_motion(path, ARM)
    assert isinstance(found, Trajectory)
    return found


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_gives_the_same_polynomials(kind: Format, tmp_path: Path) -> None:
    found = read_back(export(MADE, kind), kind, tmp_path)
    np.testing.assert_array_equal(found.nanoseconds, MADE.nanoseconds)
    np.testing.assert_array_equal(found.coefficients, MADE.coefficients)


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("given", [1, 2])
def test_what_has_no_accelerations_is_not_given_any(given: int, kind: Format, tmp_path: Path) -> None:
    """A controller would run other polynomials if it were."""
    still = [0.0 * MADE.knots(1)] * (given - 1)
    plain = Trajectory.from_points(ARM.joints, MADE.times, MADE.knots(), *still)
    found = read_back(export(plain, kind), kind, tmp_path)
    assert found.interpolation == plain.interpolation == ("lines", "cubics")[given - 1]
    np.testing.assert_allclose(found.coefficients, plain.coefficients, atol=1e-14)


def test_the_first_point_can_be_left_out(tmp_path: Path) -> None:
    found = read_back(export(MADE, "ros-json", skip_first_point=True), "ros-json", tmp_path)
    np.testing.assert_allclose(found.times, MADE.times[1:], rtol=1e-15)
    np.testing.assert_allclose(found.coefficients, MADE.coefficients[1:], atol=1e-14)


@pytest.mark.parametrize("kind", ["ros-json"])
def test_ros_reads_the_messages_as_yaml(kind: Format) -> None:
    """ROS reads YAML 1.1, to which 1e-09 is a text."""
    tiny = replace(MADE, columns=tuple(1e-9 * rows for rows in MADE.columns))
    message = yaml.safe_load(export(tiny, kind))
    assert message["joint_names"] == [A, B]
    times = [p["time_from_start"]["sec"] * 10**9 + p["time_from_start"]["nanosec"] for p in message["points"]]
    assert all(0 <= p["time_from_start"]["nanosec"] < 10**9 for p in message["points"])
    assert (np.diff(times) > 0).all()
    assert message["points"][-1]["velocities"] == [0.0, 0.0]
    values = [v for p in message["points"] for v in (*p["positions"], *p["velocities"])]
    assert all(isinstance(value, float) for value in values)
    assert json.loads(export(tiny, "ros-json"))["points"] == message["points"]


def test_overlong_motions_are_refused() -> None:
    with pytest.raises(PlannerError, match="a ROS duration"):
        export(replace(MADE, nanoseconds=MADE.nanoseconds * 10**9 * 2), "ros-json")


@pytest.mark.parametrize("name", ["a,b", 'a"', "a\nb"])
def test_a_csv_has_a_column_for_each_joint(name: str) -> None:
    with pytest.raises(PlannerError, match="must not hold commas or quotes"):
        export(replace(MADE, joints=(name, B)), "csv")


# the fields of messages, as trajectory_msgs, std_msgs and builtin_interfaces define them
FIELDS = {
    "JointTrajectory": {"header": "Header", "joint_names": None, "points": ["JointTrajectoryPoint"]},
    "Header": {"stamp": "Time", "frame_id": None},
    "Time": {"sec": None, "nanosec": None},
    "JointTrajectoryPoint": {
        **dict.fromkeys(("positions", "velocities", "accelerations", "effort")),
        "time_from_start": "Time",
    },
}


def set_message_fields(kind: str, values: dict[str, Any]) -> None:
    """As rosidl_runtime_py does: a field that a message has not is an AttributeError there."""
    for name, value in values.items():
        match FIELDS[kind][name]:
            case [inner]:
                for each in value:
                    set_message_fields(inner, each)
            case str(inner):
                set_message_fields(inner, value)


@pytest.mark.parametrize("accepted", [True, False])
def test_the_script_sends_the_file(
    accepted: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Among stand-ins for ROS 2, which is not here: its modules, an action client and a controller's answer."""
    file, ros = tmp_path / "a b.json", MagicMock()
    file.write_bytes(export(MADE, "ros-json"))
    ros.FollowJointTrajectory.Goal().trajectory = "JointTrajectory"
    ros.set_message_fields = Mock(side_effect=set_message_fields)
    send = ros.rclpy.action.ActionClient.return_value.send_goal_async
    send.return_value.result.return_value.accepted = accepted
    modules = {"rclpy": ros.rclpy, "rclpy.action": ros.rclpy.action, "rosidl_runtime_py": ros}
    for name, module in (modules | {"control_msgs": ros, "control_msgs.action": ros}).items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(sys, "argv", ["send_trajectory.py", str(file), "/arm_controller"])
    with nullcontext() if accepted else pytest.raises(SystemExit, match="refuses the trajectory"):
        exec(compile(SENDER, "send_trajectory.py", "exec"), {})
    assert ros.rclpy.action.ActionClient.call_args.args[2] == "/arm_controller/follow_joint_trajectory"
    assert ros.set_message_fields.call_args.args[1] == json.loads(export(MADE, "ros-json"))
    send.assert_called_once_with(ros.FollowJointTrajectory.Goal())
    assert bool(capsys.readouterr().out) == accepted
