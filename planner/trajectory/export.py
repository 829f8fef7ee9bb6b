"""Export of a trajectory for controllers, as its own points or at a fixed rate; reading of ROS 2 bags.

A ROS 2 joint trajectory controller runs positions as lines, positions and velocities as cubics, and with accelerations
as quintics. The points are the knots of the trajectory's own polynomials with the columns that make the controller
interpolate exactly these: it runs what was proven.

Samples of the curve would not do as rows at a fixed rate: a controller runs one polynomial between two rows, and where
the jerk of the curve changes this takes up to 1.75 times the jerk, at any rate. The rows are therefore those of a
uniform B-spline with the curve at every period as control points, of degree 1, 2 or 3 for lines, cubics or quintics.
Its derivatives are weighted means of the curve's with nonnegative weights (de Boor: A Practical Guide to Splines,
1978): it keeps each limit that the curve keeps, at any rate, and rests where the curve rests. Between two rows it is
one polynomial, the one that a controller makes of the rows. It lags by half a period for each degree above 1, and
leaves the curve by at most a sixth of the acceleration times the period squared (quintics): so it is proven again.
"""

import io
import json
from dataclasses import replace
from fractions import Fraction
from math import ceil
from pathlib import Path
from typing import Any, Literal

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import FileError, OptionError, choices, require_extra
from planner.base.yamlfile import quote
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.trajectory.curve import min_knot_interval
from planner.trajectory.limits import KINDS, MotionLimits
from planner.trajectory.proof import prove_motion
from planner.trajectory.trajectory import NANOSECOND, Trajectory

Format = Literal["ros-json", "csv", "mcap"]
SUFFIX: dict[Format, str] = {"ros-json": "json", "csv": "csv", "mcap": "mcap"}
_PER_SECOND = 1_000_000_000
_LONGEST = 2**31 - 1  # s: the seconds of a ROS duration are an int32
_MOST_ROWS = 5_000_000
_AT_REST = 1e-9  # of a limit's unit: rounding error of 0
_WEIGHTS = {1: (1.0,), 2: (0.5, 0.5), 3: (1 / 6, 4 / 6, 1 / 6)}  # of neighbouring control points, by degree
TYPE, TOPIC = "trajectory_msgs/msg/JointTrajectory", "/joint_trajectory"
_READ = (TYPE, "moveit_msgs/msg/RobotTrajectory", "moveit_msgs/msg/DisplayTrajectory")
_RULE = "=" * 80
_DEFINITION = f"""std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint[] points
{_RULE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_RULE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{_RULE}
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
{_RULE}
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"""
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
    sys.exit("the controller refuses the trajectory: see its log")
rclpy.spin_until_future_complete(node, done := sent.result().get_result_async())
print(done.result().result)
"""


def export(trajectory: Trajectory, format: Format, skip_first_point: bool = False) -> bytes:
    """Return the content of a file in this ``format``, point by point; times start at the first point.

    ``skip_first_point`` omits the first one, the robot's state: some controllers refuse a point at time 0. The other
    points keep their times. Raises :class:`OptionError` for another ``format``.
    """
    if format not in SUFFIX:
        raise OptionError(f"format '{format}' not found; formats are {choices(SUFFIX)}.")
    first = int(skip_first_point)
    nanoseconds, columns = _clock(trajectory)[first:], [rows[first:] for rows in trajectory.columns]
    if format == "csv":
        return _csv(trajectory.joints, nanoseconds, columns).encode()
    message = _message(trajectory.joints, nanoseconds, columns)
    return write_bag(message) if format == "mcap" else (_yaml_safe_json(message) + "\n").encode()


def _clock(trajectory: Trajectory) -> Ints:
    """Return the whole nanoseconds of all points from the first one."""
    clock = trajectory.nanoseconds - trajectory.nanoseconds[0]
    if clock[-1] > _LONGEST * _PER_SECOND:
        seconds = trajectory.duration
        raise FileError(f"duration must be at most {_LONGEST} s (a ROS duration), got {seconds:g} s: shorten it.")
    return clock


def _message(joints: tuple[str, ...], nanoseconds: Ints, columns: list[Floats]) -> dict[str, Any]:
    """Return a trajectory_msgs/JointTrajectory as plain data."""
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


def _yaml_safe_json(value: Any) -> str:
    """Return JSON that YAML 1.1, which ROS reads, parses alike: it would read 1e-09 as a text."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)}: {_yaml_safe_json(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_yaml_safe_json, value)) + "]"
    text = json.dumps(value, allow_nan=False)
    return text.replace("e", ".0e") if isinstance(value, float) and "." not in text else text


def _csv(joints: tuple[str, ...], nanoseconds: Ints, columns: list[Floats]) -> str:
    odd = [joint for joint in joints if set(joint) & set(',"\r\n')]
    if odd:
        raise FileError(
            f"joint names in csv must not hold commas or quotes, got {choices(odd)}: choose another --format."
        )
    names = [
        "t",
        *(f"{joint}{ending}" for ending in ("", "_velocity", "_acceleration")[: len(columns)] for joint in joints),
    ]
    lines = [",".join(names)]
    for t, row in zip(nanoseconds.tolist(), np.concatenate(columns, axis=1).tolist(), strict=True):
        lines.append(",".join([f"{t // _PER_SECOND}.{t % _PER_SECOND:09d}", *map(repr, row)]))
    return "\n".join(lines) + "\n"


def require_rate(rate: float) -> None:
    """Raise :class:`OptionError` unless ``rate`` (Hz) is usable for a controller."""
    if not 0.1 <= rate <= 10_000.0:
        raise OptionError(f"rate must be from 0.1 to 10000 Hz, got {rate:g}.")


def period_of(rate: float) -> Fraction:
    """Return the exact nanoseconds between rows at a ``rate`` (Hz), read as a decimal number."""
    require_rate(rate)
    return _PER_SECOND / Fraction(str(rate))


def resample(trajectory: Trajectory, rate: float, checker: CollisionChecker | None = None) -> Trajectory:
    """Return the motion with a row every 1 / ``rate`` s, from rest to rest; the last row is at the end.

    It is up to a period longer than the trajectory, and one more (cubics) or two (quintics), and keeps the same limits.
    It is proven only with a ``checker``. Raises :class:`OptionError` for a rate at which rounding breaks the limits,
    and :class:`FileError` for a trajectory that does not start and end at rest.
    """
    period = period_of(rate)
    _require_rest(trajectory)
    _require_usable_rate(trajectory, rate)
    degree = len(trajectory.columns)
    cycles = ceil(int(trajectory.nanoseconds[-1] - trajectory.nanoseconds[0]) / period)
    clock, late = _row_times(period, cycles + degree)
    points = _control_points(trajectory, period, late if degree == 1 else np.zeros(cycles + 1))
    columns = _rows(points, degree, float(period) * NANOSECOND, late)
    times, how = trajectory.nanoseconds[0] + clock, (trajectory.time_law, trajectory.limits)
    motion = Trajectory(trajectory.joints, times, columns, *how)
    return motion if checker is None else _prove(motion, trajectory, checker)


def deviation_from_curve(motion: Trajectory, trajectory: Trajectory) -> float:
    """Return the largest distance (rad, m) of a motion of :func:`resample` from ``trajectory``.

    It is sampled at the rows and halfway between them.
    """
    clock = np.sort(np.concatenate([motion.nanoseconds, motion.nanoseconds[:-1] + np.diff(motion.nanoseconds) // 2]))
    behind = 0.5 * (len(motion.columns) - 1) * float(np.diff(motion.nanoseconds).mean())
    return float(np.abs(motion.at_nanoseconds(clock) - trajectory.at_nanoseconds(clock - behind)).max())


def _control_points(trajectory: Trajectory, period: Fraction, late: Floats) -> Floats:
    """Return control points (m, dof): the curve at every period, ``late`` (n,) s, and repeated ends.

    The spline rests at its ends through the repetition.
    """
    begin, more = int(trajectory.nanoseconds[0]), len(trajectory.columns) - 1
    times = np.array([k * period.numerator / period.denominator for k in range(len(late))])
    points = trajectory.at_nanoseconds(begin + times + late / NANOSECOND)
    points[0], points[-1] = trajectory.columns[0][0], trajectory.columns[0][-1]
    return np.concatenate([np.repeat(points[:1], more, axis=0), points, np.repeat(points[-1:], more, axis=0)])


def _row_times(period: Fraction, count: int) -> tuple[Ints, Floats]:
    """Return the times (count,) of rows in whole nanoseconds, and their delay (s) by the rounding."""
    n, d = period.numerator, period.denominator
    clock = [(2 * k * n + d) // (2 * d) for k in range(count)]
    late = [(t * d - k * n) / d * NANOSECOND for k, t in enumerate(clock)]
    return np.array(clock, dtype=np.int64), np.array(late)


def _rows(points: Floats, degree: int, seconds: float, late: Floats) -> tuple[Floats, ...]:
    """Return positions of the B-spline at every row (n, dof), and derivatives below its ``degree``.

    The rows are ``late`` (n,) s.
    """
    count = len(points) - degree + 1
    q = sum((weight * points[k : k + count] for k, weight in enumerate(_WEIGHTS[degree])), np.zeros(1))
    if degree == 1:
        return (q,)
    qd = (points[degree - 1 :] - points[:count]) / ((degree - 1) * seconds)
    qdd = np.zeros_like(q) if degree == 2 else np.diff(points, 2, axis=0) / seconds**2
    columns = q + late[:, None] * qd, qd + late[:, None] * qdd, qdd
    for rows, ends in zip(columns, (points[[0, -1]], 0.0, 0.0), strict=True):
        rows[[0, -1]] = ends
    return columns[:degree]


def _prove(motion: Trajectory, original: Trajectory, checker: CollisionChecker) -> Trajectory:
    floor = original.proof.get("floor", {}).get("asked", 0.0)
    limits = motion.limits or MotionLimits.from_robot(checker.robot)
    proof = prove_motion(motion, EdgeProver(checker), limits, floor, kinds=KINDS[: len(motion.columns)])
    return replace(motion, proven=proof.whole, proof=proof.to_dict(checker.world.margin, checker.name))


def _require_rest(trajectory: Trajectory) -> None:
    for name, ends in zip(("velocity", "acceleration"), trajectory.columns[1:], strict=False):
        for when, row in (("begins", ends[0]), ("ends", ends[-1])):
            joint = int(np.abs(row).argmax())
            if abs(row[joint]) > _AT_REST:
                raise FileError(
                    f"a trajectory must start and end at rest for --rate, got one that {when} with a {name} of "
                    f"{row[joint]:.3g} of joint '{trajectory.joints[joint]}': leave --rate out."
                )


def _require_usable_rate(trajectory: Trajectory, rate: float) -> None:
    """Raise :class:`OptionError` for too many rows, or for rows closer than rounding allows."""
    rows, limits, positions = trajectory.duration * rate, trajectory.limits, trajectory.columns[0]
    interval = 0 if limits is None else min_knot_interval(limits, positions, KINDS[: len(trajectory.columns)])
    if interval > period_of(rate):
        raise OptionError(
            f"rate must be at most {10 * _PER_SECOND // interval / 10:g} Hz here, got {rate:g} Hz: at a higher rate "
            "rounded positions break the limits."
        )
    if rows > _MOST_ROWS:
        raise OptionError(
            f"rate must make at most {_MOST_ROWS} rows, got {rows:.3g} ({rate:g} Hz for {trajectory.duration:g} s): "
            "give a lower one."
        )


def write_bag(message: dict[str, Any]) -> bytes:
    """Return an MCAP file with a JointTrajectory of plain data with ``joint_names`` and ``points``."""
    library, file = require_extra("mcap_ros2.writer", "mcap"), io.BytesIO()
    writer = library.Writer(file, compression=require_extra("mcap.writer", "mcap").CompressionType.NONE)
    schema = writer.register_msgdef(TYPE, _DEFINITION)
    writer.write_message(TOPIC, schema, message, log_time=0, publish_time=0)
    writer.finish()
    return file.getvalue()


def read_bag(path: Path, where: str) -> tuple[dict[str, Any], int]:
    """Return the first JointTrajectory of an MCAP file as plain data, and their number.

    MoveIt's RobotTrajectory and DisplayTrajectory, which wrap one, count too. Raises :class:`FileError` for a file
    without one.
    """
    factory, first, count = require_extra("mcap_ros2.decoder", "mcap").DecoderFactory(), None, 0
    try:
        with path.open("rb") as file:
            for schema, channel, message in require_extra("mcap.reader", "mcap").make_reader(file).iter_messages():
                if schema is not None and schema.name in _READ:
                    _require_readable(channel.message_encoding, message.data, where)
                    first = first or _to_plain(factory.decoder_for("cdr", schema)(message.data))
                    count += 1
        if first is not None:
            return first, count
    except FileNotFoundError:
        raise FileError(f"{where} not found: check the path.") from None
    except FileError:
        raise
    except Exception as error:  # the library raises errors of many kinds
        raise FileError(f"{where} must be an MCAP file, got {type(error).__name__}; write it again.") from None
    raise FileError(f"{where}: message of type {choices(_READ)} not found: record one.")


def _require_readable(encoding: str, data: bytes, where: str) -> None:
    """Raise :class:`FileError` for another encoding than CDR, which the first two bytes name."""
    kind = data[:2]
    if encoding != "cdr" or kind not in (b"\x00\x00", b"\x00\x01"):
        raise FileError(
            f"{where}: trajectories must be in plain CDR, got {quote(encoding)} of kind 0x{kind.hex()}: record "
            "it as ROS 2 does."
        )


def _to_plain(message: Any) -> Any:
    """Return a decoded message as mappings and lists."""
    if isinstance(message, list | tuple):
        return [_to_plain(item) for item in message]
    if hasattr(message, "__slots__"):
        return {name: _to_plain(getattr(message, name)) for name in message.__slots__}
    return message
