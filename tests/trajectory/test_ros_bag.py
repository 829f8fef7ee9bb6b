"""Bags in MCAP: the message is CDR as ROS 2 writes it, and what cannot be read is told in one sentence."""

import io
import struct
from pathlib import Path

import pytest

from planner.base.errors import FileError
from planner.trajectory.export import TOPIC, TYPE, read_bag, write_bag

MESSAGE = {
    "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
    "joint_names": ["a", "elbow"],
    "points": [
        {
            "positions": [0.5, -1.25],
            "velocities": [1.0, 2.0],
            "accelerations": [],
            "effort": [],
            "time_from_start": {"sec": 3, "nanosec": 7},
        }
    ],
}
# by hand, from the rules of CDR: numbers at multiples of their size, lengths before texts and lists
CDR = (
    b"\x00\x01\x00\x00"
    + struct.pack("<iII", 0, 0, 1)
    + b"\0" * 4  # frame_id: its zero, and three to the next multiple of 4
    + struct.pack("<II", 2, 2)
    + b"a\0\0\0"
    + struct.pack("<I", 6)
    + b"elbow\0\0\0"
    + struct.pack("<II2d", 1, 2, 0.5, -1.25)
    + struct.pack("<II2d", 2, 0, 1.0, 2.0)
    + struct.pack("<IIiI", 0, 0, 3, 7)
)


def test_the_message_is_cdr(tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    content = write_bag(MESSAGE)
    ((schema, channel, message),) = reader.make_reader(io.BytesIO(content)).iter_messages()
    assert (schema.name, schema.encoding, channel.topic, channel.message_encoding) == (TYPE, "ros2msg", TOPIC, "cdr")
    assert message.data == CDR
    (tmp_path / "a.mcap").write_bytes(content)
    assert read_bag(tmp_path / "a.mcap", "bag") == (MESSAGE, 1)


@pytest.mark.parametrize("size", [0, 40, 700])
def test_damaged_bags_are_refused(size: int, tmp_path: Path) -> None:
    pytest.importorskip("mcap.reader")
    (tmp_path / "a.mcap").write_bytes(write_bag(MESSAGE)[:size])
    with pytest.raises(FileError, match="bag must be an MCAP file"):
        read_bag(tmp_path / "a.mcap", "bag")


@pytest.mark.parametrize(("encoding", "data"), [("cdr", b"\0\7" + CDR[2:]), ("json", b"{}")])
def test_other_encodings_are_refused(encoding: str, data: bytes, tmp_path: Path) -> None:
    """XCDR2 holds its numbers at other places."""
    library = pytest.importorskip("mcap.writer")
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = library.Writer(file)
        writer.start()
        schema = writer.register_schema(name=TYPE, encoding="ros2msg", data=b"")
        channel = writer.register_channel(topic=TOPIC, message_encoding=encoding, schema_id=schema)
        writer.add_message(channel_id=channel, log_time=0, publish_time=0, sequence=0, data=data)
        writer.finish()
    with pytest.raises(FileError, match="must be in plain CDR"):
        read_bag(tmp_path / "a.mcap", "it")
