"""Joint paths in the usual file formats: our own JSON, plain rows, MoveIt's trajectories, CSV with or without names."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError, choices
from planner.base.formats import require_readable_version
from planner.base.yamlfile import read_text, shown
from planner.world.robot import Robot

_NAMES = ("joints", "joint_names")
_ROWS = ("path", "waypoints", "positions")
_FAR = 1000.0  # rad or m: no arm turns 160 times, and looking along such a path every millimetre would not end
_FORMATS = "a plan.json, a list of rows, {joints, path}, {joint_names, points} or a CSV"


@dataclass(frozen=True, eq=False)
class PathFile:
    """Rows (k, columns) of a file in its own order; ``names`` of the columns and the ``robot`` where it says so."""

    rows: Floats
    names: tuple[str, ...] | None = None
    robot: str | None = None


def read_joint_path(path: Path, robot: Robot) -> Floats:
    """The joint path (k, dof) of a .json or .csv file, in the robot's order of joints, rad (m where prismatic).

    Named columns are put in order and others left out; without names there must be one column a planned joint.
    Continuous joints are unwound: each step is at most half a turn. Raises :class:`FileError` for a file that
    cannot be read or is for another robot.
    """
    where = f"joint path {path}"
    text = read_text(path, "joint path")
    match path.suffix.lower():
        case ".json":
            content = _from_json(parse(text, where), where)
        case ".csv":
            content = _from_csv(text, robot, where)
        case other:
            raise FileError(f"{where} ends in '{other}': give a .json or .csv file.")
    rows = in_order(content, robot, where)
    bad = np.argwhere(~np.isfinite(rows))
    if len(bad):
        row, joint = bad[0]
        raise FileError(f"{where}: row {row + 1} has no finite value for joint '{robot.joints[joint]}'; mend the file.")
    far = np.argwhere(np.abs(rows) > _FAR)
    if len(far):
        row, joint = far[0]
        raise FileError(
            f"{where}: row {row + 1} puts joint '{robot.joints[joint]}' at {rows[row, joint]:g}, beyond any joint's "
            f"{_FAR:g}; mend the file."
        )
    return frozen(np.where(robot.continuous, robot.unwound(rows), rows))  # other joints to the last bit


def in_order(content: PathFile, robot: Robot, where: str) -> Floats:
    """The rows with their columns in the robot's order of joints; :class:`FileError` where that cannot be."""
    if content.robot not in (None, robot.name):
        raise FileError(f"{where} is for robot {shown(content.robot)}, not '{robot.name}': choose it with --robot.")
    if not len(content.rows):
        raise FileError(f"{where} holds no rows: give at least one configuration.")
    if content.names is None:
        if content.rows.shape[1] != robot.dof:
            raise FileError(
                f"{where} has {content.rows.shape[1]} columns without names, {robot.name} has {robot.dof} planned "
                f"joints ({choices(robot.joints)}): give one column each, or name the columns."
            )
        return content.rows
    if len(content.names) != content.rows.shape[1]:
        raise FileError(f"{where} names {len(content.names)} columns and has {content.rows.shape[1]}: mend the file.")
    for joint in robot.joints:
        if content.names.count(joint) != 1:
            often = "twice" if joint in content.names else "nowhere"
            raise FileError(
                f"{where} names joint '{joint}' {often}; it names {choices(content.names)}: choose another --robot, "
                "or mend the file."
            )
    return content.rows[:, [content.names.index(joint) for joint in robot.joints]]


def parse(text: str, where: str) -> Any:
    """Plain data out of JSON text."""
    try:
        return json.loads(text)
    except ValueError as error:
        raise FileError(f"{where} is no JSON: {error}; mend the file.") from None
    except RecursionError:
        raise FileError(f"{where} is nested too deeply to be a joint path; give {_FORMATS}.") from None


def _from_json(data: Any, where: str) -> PathFile:
    """A path out of plain data; trajectories may be wrapped as ROS messages wrap them."""
    if isinstance(data, list):
        return PathFile(matrix(data, where))
    if isinstance(data, dict):
        require_readable_version(data, where)
        if "intervals" in data:
            raise FileError(
                f"{where} is a sweep, one path an interval of beta: save the 'path' of one of its intervals as a file "
                "of its own, or plan with 'planner plan --beta'."
            )
        require_no_moving_base(data, where)
        if "joint_trajectory" in data:
            return _from_json(data["joint_trajectory"], where)
        if isinstance(data.get("trajectory"), list) and len(data["trajectory"]) == 1:
            return _from_json(data["trajectory"][0], where)
        rows = _rows_of(data, where)
        if rows is not None:
            return PathFile(matrix(rows, where), joint_names(data, where), _text(data.get("robot")))
    raise FileError(f"{where} holds no path: give {_FORMATS}.")


def require_no_moving_base(data: dict[str, Any], where: str) -> None:
    """Raise :class:`FileError` for a RobotTrajectory that moves joints of several degrees of freedom too."""
    other = data.get("multi_dof_joint_trajectory")
    if isinstance(other, dict) and other.get("points"):
        raise FileError(
            f"{where} moves a base too (multi_dof_joint_trajectory), which is not supported: give one of the arm alone."
        )


def _rows_of(data: dict[str, Any], where: str) -> Any:
    if data.get("path") == [] and data.get("outcome") not in (None, "solved"):
        raise FileError(f"{where} is a plan that found no path (outcome '{data['outcome']}'): there is none to check.")
    if isinstance(data.get("points"), list):
        return [point.get("positions") if isinstance(point, dict) else point for point in data["points"]]
    return next((data[key] for key in _ROWS if key in data), None)


def joint_names(data: dict[str, Any], where: str) -> tuple[str, ...] | None:
    """The names of the columns, None where a file gives none."""
    names = next((data[key] for key in _NAMES if key in data), None)
    if names is None:
        return None
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise FileError(f"{where}: its joint names are no list of names; mend the file.")
    return tuple(names)


def _text(value: Any) -> str | None:
    return value if isinstance(value, str) else None


def _from_csv(text: str, robot: Robot, where: str) -> PathFile:
    """Commas, semicolons, tabs or blanks between columns; a first line of names, behind a # or not; # lines skipped."""
    lines = [line.strip() for line in text.lstrip("\ufeff").splitlines() if line.strip()]
    names = None
    if lines:
        first = cells(lines[0].lstrip("# "))
        if set(first) & set(robot.joints) or (not lines[0].startswith("#") and not all(map(is_number, first))):
            names = tuple(first)
    table = [cells(line) for line in lines[names is not None :] if not line.startswith("#")]
    if names is not None:  # a column that is not asked for may hold words
        table = [[cell if is_number(cell) else "nan" for cell in row] for row in table]
    return PathFile(matrix(table, where), names)


def cells(line: str) -> list[str]:
    """The columns of a line of a CSV, whatever separates them."""
    for mark in (",", ";", "\t"):
        if mark in line:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=mark))]
    return line.split()


def is_number(text: str) -> bool:
    """Whether a cell of a CSV holds a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def matrix(rows: Any, where: str) -> Floats:
    """Rows of numbers, or of their text, of equal length, as an array (k, columns)."""
    if not isinstance(rows, Sequence) or isinstance(rows, str):
        raise FileError(f"{where} holds no list of rows: give {_FORMATS}.")
    width = len(rows[0]) if rows and isinstance(rows[0], list) else 0
    values = np.zeros((len(rows), width))
    for k, row in enumerate(rows):
        if not isinstance(row, list) or len(row) != width or not width:
            size = f"{len(row)} values" if isinstance(row, list) else "no list of values"
            raise FileError(f"{where}: row {k + 1} has {size}, the first row has {width}; mend the file.")
        try:
            values[k] = [_number(cell) for cell in row]
        except (TypeError, ValueError):
            raise FileError(f"{where}: row {k + 1} holds something that is no number; mend the file.") from None
    return values


def _number(cell: Any) -> float:
    if isinstance(cell, bool) or not isinstance(cell, (int, float, str)):
        raise TypeError(cell)
    return float(cell)
