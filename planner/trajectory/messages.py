"""Points with times out of plain data: our own ``trajectory.json`` and ROS messages, each field honoured or refused."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import FileError, choices
from planner.base.yamlfile import number, shown
from planner.trajectory.file import KEYS, POINT_KEYS
from planner.trajectory.path_file import OF_A_POINT, joint_names, matrix, require_header, require_known, unwrapped
from planner.trajectory.trajectory import DEGREE

OWN = ("q", "qd", "qdd")
_OF_A_MESSAGE = ("header", "joint_names", "points")
_CLOCKS = (("sec", "nanosec"), ("secs", "nsecs"))  # of ROS 2 and of ROS 1
_PER_SECOND = 1_000_000_000
EVENTS = "events of a task (attach, detach, gripper) are not followed: check the plan.json that it was written with"


@dataclass(frozen=True, eq=False)
class Raw:
    """What a file holds: ``times`` (k,) s, ``columns`` (k, names) each, joint ``names`` and ``robot`` if it says so.

    The columns are positions, perhaps velocities, perhaps accelerations. ``notes`` say what is left aside.
    """

    times: Floats
    columns: tuple[Floats, ...]
    names: tuple[str, ...] | None
    robot: str | None = None
    notes: tuple[str, ...] = ()


def points_of(data: Any, where: str) -> Raw | None:
    """The points with times of plain data; None where it has none. Raises :class:`FileError` for what is in doubt."""
    if isinstance(data, dict) and "outcome" in data:
        return None  # a plan.json, whose trajectory stands beside it
    data, notes = unwrapped(data, where)
    points = data.get("points") if isinstance(data, dict) else None
    if isinstance(points, str) or (isinstance(points, list) and "..." in points):
        raise FileError(f"{where} lacks points that 'ros2 topic echo' left out: write it with --full-length.")
    if not isinstance(points, list) or not points or not all(isinstance(point, dict) for point in points):
        return None
    own = any("q" in point or "t" in point for point in points)
    clock = "t" if own else "time_from_start"
    timed = ["t" in point if own else "time_from_start" in point for point in points]
    if not any(timed):
        return None
    if not all(timed):
        raise FileError(f"{where}: point {timed.index(False) + 1} has no {clock}, others have: give it for all.")
    require_known(data, KEYS if own else _OF_A_MESSAGE, where)
    for k, point in enumerate(points, 1):
        require_known(point, POINT_KEYS if own else OF_A_POINT, f"{where}: point {k}")
    times = np.array([_seconds(point[clock], f"{where}: point {k}") for k, point in enumerate(points, 1)])
    keys = OWN[: _given(data.get("interpolation"), where)] if own else OF_A_POINT[:3]
    names = joint_names(data, where)
    if own and data.get("events"):
        notes.append(EVENTS)
    if not own:
        notes += _notes_on(data, points, where)
        if not names:
            raise FileError(f"{where} names no joints, which a joint trajectory controller refuses: add joint_names.")
    columns = as_columns([_column(points, key, where) for key in keys], where)
    return Raw(times, columns, names, data.get("robot") if own else None, tuple(notes))


def as_columns(given: list[Floats | None], where: str) -> tuple[Floats, ...]:
    """Positions, velocities and accelerations as far as they are given; each needs the one before it."""
    if len(given) > 2 and given[1] is None and given[2] is not None:
        raise FileError(
            f"{where} gives accelerations and no velocities, between which a ROS 2 joint trajectory controller "
            "interpolates nothing and commands zeros: give velocities too, or leave the accelerations out."
        )
    return tuple(rows for rows in given if rows is not None)


def _notes_on(message: dict[str, Any], points: list[dict[str, Any]], where: str) -> list[str]:
    notes, header = [], message.get("header") or {}
    require_header(header, where)
    stamp = header.get("stamp")
    if any(stamp.values()) if isinstance(stamp, dict) else stamp:
        notes.append("the header's stamp, when a controller is to begin, is not looked at")
    if any(point.get("effort") for point in points):
        notes.append("effort is not checked, and refused by a controller that does not command it")
    return notes


def _given(interpolation: Any, where: str) -> int:
    """How many of position, velocity and acceleration our own file's pieces go through; all that it has by default."""
    if interpolation is None:
        return len(OWN)
    if not isinstance(interpolation, str) or interpolation not in DEGREE:
        raise FileError(f"{where}: its interpolation is {shown(interpolation)}; give one of {choices(DEGREE)}.")
    return (DEGREE[interpolation] + 1) // 2


def _column(points: list[dict[str, Any]], key: str, where: str) -> Floats | None:
    """The rows under a key of all points; None where none has it."""
    has = [key in point and point[key] not in (None, []) for point in points]
    if not any(has) and key not in ("q", "positions"):
        return None
    if not all(has):
        others = ", others have: give all or none of them" if any(has) else ": give them"
        raise FileError(f"{where}: point {has.index(False) + 1} has no {key}{others}.")
    return matrix([point[key] for point in points], where)


def _seconds(value: Any, where: str) -> float:
    """A duration as a ROS 1 or ROS 2 message has it, or a number of seconds."""
    if isinstance(value, dict):
        names = next((names for names in _CLOCKS if value and set(value) <= set(names)), None)
        if names is None:
            raise FileError(f"{where}: {shown(value)} is no time; give sec and nanosec, or seconds.")
        whole, part = (_whole(value.get(name, 0), name, where) for name in names)
        if not 0 <= part < _PER_SECOND:
            raise FileError(f"{where}: {names[1]} {part} is not usable: give 0 to {_PER_SECOND - 1}.")
        return (whole * _PER_SECOND + part) / _PER_SECOND
    try:
        if not isinstance(value, bool):
            return number(value) if isinstance(value, str) else float(value)
    except (TypeError, ValueError, OverflowError):
        pass
    raise FileError(f"{where}: {shown(value)} is no time; give sec and nanosec, or seconds.")


def _whole(value: Any, name: str, where: str) -> int:
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, bool) or not isinstance(value, int):
        raise FileError(f"{where}: {name} {shown(value)} is no whole number; give sec and nanosec as integers.")
    if abs(value) >= 2**31:
        raise FileError(f"{where}: {name} {shown(value)} is not usable: a ROS duration holds less than 2^31 s.")
    return value
