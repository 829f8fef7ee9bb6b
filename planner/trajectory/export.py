"""A trajectory as a file for controllers: its own points, or rows of a clock; and the message of a ROS 2 bag read.

A ROS 2 joint trajectory controller runs positions as lines, positions and velocities as cubics, and with accelerations
as quintics. The points are the knots of the trajectory's own polynomials, with what makes the controller interpolate
these and nothing more: what it runs is what was proven.

Samples of the curve would not do as rows of a clock. Between two of them a controller runs one polynomial, and where
the jerk of the curve changes that takes up to 1.75 times the jerk, at any rate. So the rows are those of a uniform
B-spline with the curve at every period as control points, of degree 1, 2 or 3 for lines, cubics or quintics. Its
derivatives are means of the curve's, weighted with what is nowhere negative (de Boor: A Practical Guide to Splines,
1978): it keeps each limit that the curve keeps, at any rate, and rests where the curve rests. Between two rows it is
one polynomial, the one that a controller makes of the rows. It is behind by half a period for each degree above 1, and
off the curve by a sixth of the acceleration times the period squared at most (quintics): so it is proven again.
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
_AT_REST = 1e-9  # of a limit's unit: what rounding makes of nothing
_WEIGHTS = {1: (1.0,), 2: (0.5, 0.5), 3: (1 / 6, 4 / 6, 1 / 6)}  # of neighbouring control points, by degree
TYPE, TOPIC = "trajectory_msgs/msg/JointTrajectory", "/joint_trajectory"
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
    sys.exit("the controller refuses the trajectory: its log says why")
rclpy.spin_until_future_complete(node, done := sent.result().get_result_async())
print(done.result().result)
"""


def export(trajectory: Trajectory, format: Format, skip_first_point: bool = False) -> bytes:
    """The content of a file in this ``format``, point by point; times count from the first one.

    ``skip_first_point`` leaves out the first one, which is where the robot stands: some controllers refuse a point at
    time 0. The others keep their times. Raises :class:`OptionError` for another ``format``.
    """
    if format not in SUFFIX:
        raise OptionError(f"format '{format}' not found; formats are {choices(SUFFIX)}.")
    first = int(skip_first_point)
    nanoseconds, columns = _clock(trajectory)[first:], [rows[first:] for rows in trajectory.columns]
    if format == "csv":
        return _csv(trajectory.joints, nanoseconds, columns).encode()
    message = _message(trajectory.joints, nanoseconds, columns)
    return write_bag(message) if format == "mcap" else (_flow(message) + "\n").encode()


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


def require_rate(rate: float) -> None:
    """Raise :class:`OptionError` unless ``rate`` (Hz) is one that a controller can have."""
    if not 0.1 <= rate <= 10_000.0:
        raise OptionError(f"rate {rate:g} Hz is not usable: give a number from 0.1 to 10000.")


def period_of(rate: float) -> Fraction:
    """Nanoseconds from one row to the next at a ``rate`` (Hz), taken as the decimal number that it is written as."""
    require_rate(rate)
    return _PER_SECOND / Fraction(str(rate))


def resample(trajectory: Trajectory, rate: float, checker: CollisionChecker | None = None) -> Trajectory:
    """The motion with a row at every k / ``rate`` s, to the nanosecond, from rest to rest: the end is held to a row.

    It takes up to a period longer than the trajectory, and one more (cubics) or two (quintics), and keeps the same
    limits. It is proven where a ``checker`` is given, and only there. Raises :class:`OptionError` for a rate at which
    rounding breaks the limits, and :class:`FileError` for a trajectory that does not begin and end at rest.
    """
    period = period_of(rate)
    _require_rest(trajectory)
    _require_apart(trajectory, rate)
    _require_few(trajectory, rate)
    degree = len(trajectory.columns)
    cycles = ceil(int(trajectory.nanoseconds[-1] - trajectory.nanoseconds[0]) / period)
    clock, late = _clock_of_rows(period, cycles + degree)
    points = _control_points(trajectory, period, late if degree == 1 else np.zeros(cycles + 1))
    columns = _rows(points, degree, float(period) * NANOSECOND, late)
    times, how = trajectory.nanoseconds[0] + clock, (trajectory.time_law, trajectory.limits)
    made = Trajectory(trajectory.joints, times, columns, *how)
    return made if checker is None else _proven(made, trajectory, checker)


def deviation_from_curve(made: Trajectory, trajectory: Trajectory) -> float:
    """How far (rad, m) a motion of :func:`resample` leaves ``trajectory``, at its rows and halfway between them."""
    clock = np.sort(np.concatenate([made.nanoseconds, made.nanoseconds[:-1] + np.diff(made.nanoseconds) // 2]))
    behind = 0.5 * (len(made.columns) - 1) * float(np.diff(made.nanoseconds).mean())
    return float(np.abs(made.at_nanoseconds(clock) - trajectory.at_nanoseconds(clock - behind)).max())


def _control_points(trajectory: Trajectory, period: Fraction, late: Floats) -> Floats:
    """The curve at every period, each ``late`` (n,) s, its ends as often as the spline needs to rest there (m, dof)."""
    begin, more = int(trajectory.nanoseconds[0]), len(trajectory.columns) - 1
    times = np.array([k * period.numerator / period.denominator for k in range(len(late))])
    points = trajectory.at_nanoseconds(begin + times + late / NANOSECOND)
    points[0], points[-1] = trajectory.columns[0][0], trajectory.columns[0][-1]
    return np.concatenate([np.repeat(points[:1], more, axis=0), points, np.repeat(points[-1:], more, axis=0)])


def _clock_of_rows(period: Fraction, count: int) -> tuple[Ints, Floats]:
    """The first ``count`` rows' times (count,) in whole nanoseconds, and by how many seconds each is late for that."""
    n, d = period.numerator, period.denominator
    clock = [(2 * k * n + d) // (2 * d) for k in range(count)]
    late = [(t * d - k * n) / d * NANOSECOND for k, t in enumerate(clock)]
    return np.array(clock, dtype=np.int64), np.array(late)


def _rows(points: Floats, degree: int, seconds: float, late: Floats) -> tuple[Floats, ...]:
    """Positions of the B-spline, and derivatives below its ``degree``, at every row (n, dof) each, ``late`` (n,) s."""
    count = len(points) - degree + 1
    q = sum((weight * points[k : k + count] for k, weight in enumerate(_WEIGHTS[degree])), np.zeros(1))
    if degree == 1:
        return (q,)
    qd = (points[degree - 1 :] - points[:count]) / ((degree - 1) * seconds)
    qdd = np.zeros_like(q) if degree == 2 else np.diff(points, 2, axis=0) / seconds**2
    found = q + late[:, None] * qd, qd + late[:, None] * qdd, qdd
    for rows, ends in zip(found, (points[[0, -1]], 0.0, 0.0), strict=True):
        rows[[0, -1]] = ends
    return found[:degree]


def _proven(made: Trajectory, original: Trajectory, checker: CollisionChecker) -> Trajectory:
    floor = original.proof.get("floor", {}).get("asked", 0.0)
    limits = made.limits or MotionLimits.from_robot(checker.robot)
    proof = prove_motion(made, EdgeProver(checker), limits, floor, kinds=KINDS[: len(made.columns)])
    return replace(made, proven=proof.whole, proof=proof.to_dict(checker.world.margin, checker.name))


def _require_rest(trajectory: Trajectory) -> None:
    for name, ends in zip(("velocity", "acceleration"), trajectory.columns[1:], strict=False):
        for when, row in (("begins", ends[0]), ("ends", ends[-1])):
            joint = int(np.abs(row).argmax())
            if abs(row[joint]) > _AT_REST:
                raise FileError(
                    f"the trajectory {when} with a {name} of {row[joint]:.3g} of joint '{trajectory.joints[joint]}', "
                    "and on a grid a motion is from rest to rest: leave --rate out."
                )


def _require_apart(trajectory: Trajectory, rate: float) -> None:
    """Raise :class:`OptionError` for a rate at which rows are nearer to each other than rounding allows."""
    if trajectory.limits is None:
        return
    apart = min_knot_interval(trajectory.limits, trajectory.columns[0], KINDS[: len(trajectory.columns)])
    if apart > period_of(rate):
        raise OptionError(
            f"rate {rate:g} Hz is too high for this trajectory: the rounding of positions in points that near to one "
            f"another breaks its limits; give {10 * _PER_SECOND // apart / 10:g} Hz or less."
        )


def _require_few(trajectory: Trajectory, rate: float) -> None:
    rows = trajectory.duration * rate
    if rows > _MOST_ROWS:
        raise OptionError(
            f"rate {rate:g} Hz makes {rows:.3g} rows of {trajectory.duration:g} s: give one that makes {_MOST_ROWS} at "
            "most."
        )


def write_bag(message: dict[str, Any]) -> bytes:
    """An MCAP file with a JointTrajectory, given as plain data with ``joint_names`` and ``points``."""
    library, file = require_extra("mcap_ros2.writer", "mcap"), io.BytesIO()
    writer = library.Writer(file, compression=require_extra("mcap.writer", "mcap").CompressionType.NONE)
    schema = writer.register_msgdef(TYPE, _DEFINITION)
    writer.write_message(TOPIC, schema, message, log_time=0, publish_time=0)
    writer.finish()
    return file.getvalue()


def read_bag(path: Path, where: str) -> tuple[dict[str, Any], int]:
    """The first JointTrajectory of an MCAP file as plain data, and how many it has; :class:`FileError` for none."""
    factory, first, count = require_extra("mcap_ros2.decoder", "mcap").DecoderFactory(), None, 0
    try:
        with path.open("rb") as file:
            for schema, channel, message in require_extra("mcap.reader", "mcap").make_reader(file).iter_messages():
                if schema is not None and schema.name == TYPE:
                    _require_readable(channel.message_encoding, message.data, where)
                    first = first or _plain(factory.decoder_for("cdr", schema)(message.data))
                    count += 1
        if first is not None:
            return first, count
    except FileNotFoundError:
        raise FileError(f"{where} not found: check the path.") from None
    except FileError:
        raise
    except Exception as error:  # the library raises errors of many kinds
        raise FileError(f"{where} is no readable MCAP file: {type(error).__name__}; write it again.") from None
    raise FileError(f"{where} holds no message of the type {TYPE}: record one.")


def _require_readable(encoding: str, data: bytes, where: str) -> None:
    """Raise :class:`FileError` for another encoding than CDR, which the first two bytes name."""
    kind = data[:2]
    if encoding != "cdr" or kind not in (b"\x00\x00", b"\x00\x01"):
        raise FileError(
            f"{where}: its JointTrajectory is in {quote(encoding)} of kind 0x{kind.hex()}: record it in plain CDR, "
            "as ROS 2 writes it."
        )


def _plain(message: Any) -> Any:
    """A decoded message as mappings and lists."""
    if isinstance(message, list | tuple):
        return [_plain(item) for item in message]
    if hasattr(message, "__slots__"):
        return {name: _plain(getattr(message, name)) for name in message.__slots__}
    return message
