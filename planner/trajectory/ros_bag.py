"""A trajectory as the one message of a ROS 2 bag in the MCAP format, and back: the library ``mcap`` does the container.

The message is a trajectory_msgs/msg/JointTrajectory in CDR, the encoding of ROS 2 (OMG DDS-XTypes, little endian).
"""

from __future__ import annotations

import importlib
import io
import struct
from pathlib import Path
from typing import Any

from planner.base.errors import FileError, InstallationError
from planner.base.yamlfile import shown

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
_COLUMNS = ("positions", "velocities", "accelerations", "effort")
_LITTLE_ENDIAN = b"\x00\x01\x00\x00"


def require_mcap(part: str) -> Any:
    """The module ``mcap.<part>``; :class:`InstallationError` where the library is missing."""
    try:
        return importlib.import_module(f"mcap.{part}")
    except ImportError:
        raise InstallationError(
            "MCAP files need the Python package mcap: run pip install 'gabf-planner[mcap]', or choose another format."
        ) from None


def write_bag(message: dict[str, Any]) -> bytes:
    """An MCAP file with a JointTrajectory, given as plain data with ``joint_names`` and ``points``."""
    library, file = require_mcap("writer"), io.BytesIO()
    writer = library.Writer(file, compression=library.CompressionType.NONE)
    writer.start(profile="ros2", library="gabf-planner")
    schema = writer.register_schema(name=TYPE, encoding="ros2msg", data=_DEFINITION.encode())
    channel = writer.register_channel(topic=TOPIC, message_encoding="cdr", schema_id=schema)
    writer.add_message(channel_id=channel, log_time=0, publish_time=0, sequence=0, data=_encoded(message))
    writer.finish()
    return file.getvalue()


def read_bag(path: Path, where: str) -> tuple[dict[str, Any], int]:
    """The first JointTrajectory of an MCAP file as plain data, and how many it has; :class:`FileError` for none."""
    library, first, count = require_mcap("reader"), None, 0
    try:
        with path.open("rb") as file:
            for schema, channel, message in library.make_reader(file).iter_messages():
                if schema is not None and schema.name == TYPE:
                    _require_readable(channel.message_encoding, message.data, where)
                    first, count = message.data if first is None else first, count + 1
        if first is not None:
            return _decoded(first), count
    except FileNotFoundError:
        raise FileError(f"{where} not found: check the path.") from None
    except FileError:
        raise
    except Exception as error:  # of many kinds, as the library looks at what it reads
        raise FileError(f"{where} is no readable MCAP file: {type(error).__name__}; write it again.") from None
    raise FileError(f"{where} holds no message of the type {TYPE}: record one.")


def _require_readable(encoding: str, data: bytes, where: str) -> None:
    """Raise :class:`FileError` for another encoding than CDR, whose first two bytes say which kind of it follows."""
    kind = data[:2]
    if encoding != "cdr" or kind not in (b"\x00\x00", b"\x00\x01"):
        raise FileError(
            f"{where}: its JointTrajectory is in {shown(encoding)} of kind 0x{kind.hex()}: record it in plain CDR, "
            "as ROS 2 writes it."
        )


def _encoded(message: dict[str, Any]) -> bytes:
    out = bytearray()

    def number(kind: str, value: Any) -> None:
        size = struct.calcsize(kind)
        out.extend(b"\0" * (-len(out) % size))  # every number stands at a multiple of its size
        out.extend(struct.pack("<" + kind, value))

    def text(value: str) -> None:
        data = value.encode() + b"\0"
        number("I", len(data))
        out.extend(data)

    def time(value: dict[str, int]) -> None:
        number("i", value["sec"])
        number("I", value["nanosec"])

    time(message["header"]["stamp"])
    text(message["header"]["frame_id"])
    number("I", len(message["joint_names"]))
    for name in message["joint_names"]:
        text(name)
    number("I", len(message["points"]))
    for point in message["points"]:
        for key in _COLUMNS:
            number("I", len(point[key]))
            for value in point[key]:
                number("d", value)
        time(point["time_from_start"])
    return _LITTLE_ENDIAN + bytes(out)


def _decoded(data: bytes) -> dict[str, Any]:
    order, body, at = "<" if data[1] & 1 else ">", data[4:], 0

    def number(kind: str) -> Any:
        nonlocal at
        size = struct.calcsize(kind)
        at += -at % size
        (value,) = struct.unpack_from(order + kind, body, at)
        at += size
        return value

    def text() -> str:
        nonlocal at
        size = number("I")
        value = body[at : at + size]
        if len(value) < size:
            raise EOFError
        at += size
        return value.rstrip(b"\0").decode()

    def time() -> dict[str, int]:
        return {"sec": number("i"), "nanosec": number("I")}

    header = {"stamp": time(), "frame_id": text()}
    names = [text() for _ in range(number("I"))]
    points = []
    for _ in range(number("I")):
        point: dict[str, Any] = {key: [number("d") for _ in range(number("I"))] for key in _COLUMNS}
        points.append({**point, "time_from_start": time()})
    if len(body) - at > 3:  # what is left of a multiple of four
        raise EOFError
    return {"header": header, "joint_names": names, "points": points}
