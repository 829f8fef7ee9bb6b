"""A trajectory in the formats that controllers and other programs take.

A ROS 2 joint trajectory controller runs positions as lines, positions and velocities as cubics, and with accelerations
as quintics. The points are the knots of the trajectory's own polynomials, with what makes the controller interpolate
these and nothing more: what it runs is what was proven. Other points are made by :mod:`planner.trajectory.grid`.
"""

from __future__ import annotations

import json
from typing import Any, Literal

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import FileError, OptionError, choices
from planner.trajectory.ros_bag import write_bag
from planner.trajectory.trajectory import Trajectory

Format = Literal["ros-json", "csv", "mcap"]
SUFFIX: dict[Format, str] = {"ros-json": "json", "csv": "csv", "mcap": "mcap"}

_PER_SECOND = 1_000_000_000
_LONGEST = 2**31 - 1  # s: the seconds of a ROS duration are an int32
SENDER_NAME = "send_trajectory.py"
SENDER = """\
# Runs a trajectory of 'planner export --format ros-json': python3 send_trajectory.py FILE [CONTROLLER]
import json, sys
import rclpy, rclpy.action
from control_msgs.action import FollowJointTrajectory
from rosidl_runtime_py import set_message_fields

rclpy.init()
node, goal = rclpy.create_node("send_trajectory"), FollowJointTrajectory.Goal()
set_message_fields(goal.trajectory, json.load(open(sys.argv[1])))
controller = (sys.argv[2:] or ["/joint_trajectory_controller"])[0]
client = rclpy.action.ActionClient(node, FollowJointTrajectory, controller + "/follow_joint_trajectory")
client.wait_for_server()
rclpy.spin_until_future_complete(node, sent := client.send_goal_async(goal))
if not sent.result().accepted:
    sys.exit("the controller refuses the trajectory: its log says why")
rclpy.spin_until_future_complete(node, done := sent.result().get_result_async())
print(done.result().result)
"""


def export(trajectory: Trajectory, kind: Format, skip_first_point: bool = False) -> bytes:
    """The content of a file of this ``kind``, point by point; times count from the first one.

    ``skip_first_point`` leaves out the first one, which is where the robot stands: some controllers refuse a point at
    time 0. The others keep their times. Raises :class:`OptionError` for another ``kind``.
    """
    if kind not in SUFFIX:
        raise OptionError(f"format '{kind}' not found; formats are {choices(SUFFIX)}.")
    first = int(skip_first_point)
    nanoseconds, columns = _clock(trajectory)[first:], [rows[first:] for rows in trajectory.columns]
    if kind == "csv":
        return _csv(trajectory.joints, nanoseconds, columns).encode()
    message = _message(trajectory.joints, nanoseconds, columns)
    return write_bag(message) if kind == "mcap" else (_flow(message) + "\n").encode()


def _clock(trajectory: Trajectory) -> Ints:
    """Whole nanoseconds from the first point of all points."""
    clock = trajectory.nanoseconds - trajectory.nanoseconds[0]
    if clock[-1] > _LONGEST * _PER_SECOND:
        seconds = trajectory.duration
        raise FileError(f"the trajectory takes {seconds:g} s: a ROS duration holds {_LONGEST} s; give a shorter one.")
    return clock


def _message(joints: tuple[str, ...], nanoseconds: Ints, columns: list[Floats]) -> dict[str, Any]:
    """trajectory_msgs/JointTrajectory as plain data."""
    rows: list[list[list[float]]] = [column.tolist() for column in columns]
    rows += [[[] for _ in nanoseconds]] * (3 - len(rows))
    points = [
        {
            "positions": q,
            "velocities": qd,
            "accelerations": qdd,
            "effort": [],
            "time_from_start": dict(zip(("sec", "nanosec"), divmod(int(t), _PER_SECOND), strict=True)),
        }
        for t, q, qd, qdd in zip(nanoseconds, *rows, strict=True)
    ]
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    return {"header": header, "joint_names": list(joints), "points": points}


def _flow(value: Any) -> str:
    """JSON that YAML reads alike: of a number such as 1e-09 YAML 1.1, which ROS reads, would make a text."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    text = json.dumps(value, allow_nan=False)
    return text.replace("e", ".0e") if isinstance(value, float) and "." not in text else text


def _csv(joints: tuple[str, ...], nanoseconds: Ints, columns: list[Floats]) -> str:
    odd = [joint for joint in joints if set(joint) & set(',"\r\n')]
    if odd:
        raise FileError(f"a joint is called {choices(odd)}, for which csv has no place: choose another --format.")
    names = [
        "t",
        *(f"{joint}{ending}" for ending in ("", "_velocity", "_acceleration")[: len(columns)] for joint in joints),
    ]
    lines = [",".join(names)]
    for t, row in zip(nanoseconds.tolist(), np.concatenate(columns, axis=1).tolist(), strict=True):
        lines.append(",".join([f"{t // _PER_SECOND}.{t % _PER_SECOND:09d}", *map(repr, row)]))
    return "\n".join(lines) + "\n"
