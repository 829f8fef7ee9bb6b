"""A trajectory as the one message of a ROS 2 bag in the MCAP format, and back, by the library mcap-ros2-support."""

from __future__ import annotations

import importlib
import io
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


def write_bag(message: dict[str, Any]) -> bytes:
    """An MCAP file with a JointTrajectory, given as plain data with ``joint_names`` and ``points``."""
    library, file = _require("mcap_ros2.writer"), io.BytesIO()
    writer = library.Writer(file, compression=_require("mcap.writer").CompressionType.NONE)
    schema = writer.register_msgdef(TYPE, _DEFINITION)
    writer.write_message(TOPIC, schema, message, log_time=0, publish_time=0)
    writer.finish()
    return file.getvalue()


def read_bag(path: Path, where: str) -> tuple[dict[str, Any], int]:
    """The first JointTrajectory of an MCAP file as plain data, and how many it has; :class:`FileError` for none."""
    factory, first, count = _require("mcap_ros2.decoder").DecoderFactory(), None, 0
    try:
        with path.open("rb") as file:
            for schema, channel, message in _require("mcap.reader").make_reader(file).iter_messages():
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


def _require(module: str) -> Any:
    """A module of the library; :class:`InstallationError` where the library is missing."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InstallationError(
            "MCAP files need the Python package mcap-ros2-support: run pip install 'gabf-planner[mcap]', or choose "
            "another format."
        ) from None


def _require_readable(encoding: str, data: bytes, where: str) -> None:
    """Raise :class:`FileError` for another encoding than CDR, which the first two bytes name."""
    kind = data[:2]
    if encoding != "cdr" or kind not in (b"\x00\x00", b"\x00\x01"):
        raise FileError(
            f"{where}: its JointTrajectory is in {shown(encoding)} of kind 0x{kind.hex()}: record it in plain CDR, "
            "as ROS 2 writes it."
        )


def _plain(message: Any) -> Any:
    """A decoded message as mappings and lists."""
    if isinstance(message, list | tuple):
        return [_plain(item) for item in message]
    if hasattr(message, "__slots__"):
        return {name: _plain(getattr(message, name)) for name in message.__slots__}
    return message
