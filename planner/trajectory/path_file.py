"""Joint paths in the usual file formats: our own JSON, plain rows, MoveIt's trajectories, CSV with or without names."""

from __future__ import annotations

import csv
import difflib
import json
import logging
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError, choices
from planner.base.yamlfile import number, shown
from planner.problem.outcome import require_readable_version
from planner.robot.robot import HALF_TURN, Robot

_log = logging.getLogger(__name__)

_NAMES = ("joints", "joint_names")
_ROWS = ("path", "waypoints", "positions")
_OF_A_PATH = (*_NAMES, *_ROWS, "points", "robot", "scene", "header", "format_version")
_COLUMNS = ("positions", "velocities", "accelerations", "effort")
OF_A_POINT = (*_COLUMNS, "time_from_start")
TIME = "t"  # s
ENDINGS = ("_velocity", "_acceleration")
_TOLERANCES = ("path_tolerance", "goal_tolerance", "component_path_tolerance", "component_goal_tolerance")
_WRAPPERS = {  # what stands beside a message in what wraps it, as ROS names it
    "goal": ("goal_id", "header"),
    "trajectory": (*_TOLERANCES, "goal_time_tolerance", "multi_dof_trajectory", "model_id", "trajectory_start"),
    "joint_trajectory": ("multi_dof_joint_trajectory",),
}
FAR = 1000.0  # rad or m: no arm turns 160 times, and looking along such a path every millimetre would not end
_FORMATS = "a plan.json, a list of rows, {joints, path}, {joint_names, points} or a CSV"


@dataclass(frozen=True, eq=False)
class PathFile:
    """Rows (k, columns) of a file in its own order; ``names`` of the columns and the ``robot`` where it says so.

    ``notes``: what else it holds that is passed over.
    """

    rows: Floats
    names: tuple[str, ...] | None = None
    robot: str | None = None
    notes: tuple[str, ...] = ()


def joint_path(content: PathFile, robot: Robot, where: str) -> Floats:
    """The joint path (k, dof) of a file's content, in the robot's order of joints, rad (m where prismatic).

    Named columns are put in order, those of joints that are not planned left out, with a warning; without names there
    must be one column a planned joint. Continuous joints are unwound: each step is below half a turn, with a warning
    where the file has it the longer way. Raises :class:`FileError` for content of another robot, or a step of half a
    turn.
    """
    rows = in_order(content, robot, where)
    for note in (*content.notes, *left_out(content.names, robot)):
        _log.warning("%s: %s", where, note)
    require_of_an_arm(rows, robot, where)
    return frozen(np.where(robot.continuous, _unwound(rows, robot, where), rows))  # other joints to the last bit


def _unwound(rows: Floats, robot: Robot, where: str) -> Floats:
    """The rows (k, dof) with continuous joints counted on; :class:`FileError` where they do not tell which way round.

    That is half a turn, and a whole one or more, which angles brought into one turn never are apart.
    """
    step, taken = np.diff(rows, axis=0), robot.difference(rows[:-1], rows[1:])
    far = robot.continuous & (np.abs(step) >= HALF_TURN)
    untold = far & ((np.abs(taken) >= HALF_TURN) | (np.abs(step) >= np.pi + HALF_TURN))
    for row, joint in np.argwhere(untold)[:1]:
        raise FileError(
            f"{where}: from row {row + 1} to row {row + 2} joint '{robot.joints[joint]}' turns by "
            f"{step[row, joint]:.6g} rad, and it is not told which way round: give rows less than half a turn apart."
        )
    for row, joint in np.argwhere(far)[:1]:
        more = f", the first of {far.sum()} such steps" if far.sum() > 1 else ""
        _log.warning(
            "%s: from row %d to row %d joint '%s' is taken to turn the shorter way, by %.6g rad instead of %.6g%s",
            *(where, row + 1, row + 2, robot.joints[joint], taken[row, joint], step[row, joint], more),
        )
    return robot.unwound(rows)


def require_of_an_arm(rows: Floats, robot: Robot, where: str) -> None:
    """Raise :class:`FileError` for values (k, dof) that are not finite, or that no joint ever has."""
    bad = np.argwhere(~np.isfinite(rows))
    if len(bad):
        row, joint = bad[0]
        raise FileError(f"{where}: row {row + 1} has no finite value for joint '{robot.joints[joint]}'; mend the file.")
    far = np.argwhere(np.abs(rows) > FAR)
    if len(far):
        row, joint = far[0]
        raise FileError(
            f"{where}: row {row + 1} puts joint '{robot.joints[joint]}' at {rows[row, joint]:g}, beyond any joint's "
            f"{FAR:g}; mend the file."
        )


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


def left_out(names: Sequence[str] | None, robot: Robot) -> list[str]:
    """What is to be said of columns that belong to no planned joint."""
    others = [name for name in names or () if name not in robot.joints]
    if not others:
        return []
    still = ", which stay where the robot has them" if set(others) <= set(robot.fixed_joints) else ""
    still = ", which follow planned ones" if {*others} <= {item.joint for item in robot.followers} else still
    return [f"positions of {choices(others)} are left out: these are no planned joints of {robot.name}{still}"]


def require_known(keys: Iterable[Any], known: Sequence[str], where: str, what: str = "a key") -> None:
    """Raise :class:`FileError` for a key that nobody knows: what is left aside may be what matters."""
    for key in keys:
        if key not in known:
            near = difflib.get_close_matches(str(key), known, n=3, cutoff=0.5)
            mean = f"did you mean {' or '.join(map(repr, near))}? " if near else ""
            raise FileError(
                f"{where} has {what} {shown(key)} that is not known: {mean}Known are {choices(known)}; "
                "rename it, or leave it out."
            )


def require_header(header: Any, where: str) -> None:
    """Raise :class:`FileError` for what is no header of a ROS message: its date is for its readers to judge."""
    if not isinstance(header, dict):
        raise FileError(f"{where}: its header is {shown(header)}; give stamp and frame_id, or leave it out.")
    require_known(header, ("seq", "stamp", "frame_id"), f"{where}: its header")


def unwrapped(data: Any, where: str) -> tuple[Any, list[str]]:
    """The innermost message of what ROS wraps it in, and what is to be said of what stands beside it."""
    notes: list[str] = []
    while isinstance(data, dict) and not any(key in data for key in (*_ROWS, "points")):
        key = next((key for key in _WRAPPERS if isinstance(data.get(key), dict | list)), None)
        inner = data.get(key)
        if key is None or (isinstance(inner, list) and not all(isinstance(item, dict) for item in inner)):
            break
        require_known(data, (key, *_WRAPPERS[key]), where)
        if isinstance(inner, list) and len(inner) != 1:
            raise FileError(f"{where} holds {len(inner)} trajectories: give each in a file of its own.")
        for other in ("multi_dof_trajectory", "multi_dof_joint_trajectory"):
            if isinstance(data.get(other), dict) and data[other].get("points"):
                raise FileError(f"{where} moves joints of several degrees of freedom ({other}): leave these out.")
        unchecked = [name for name in (*_TOLERANCES, "goal_time_tolerance", "trajectory_start") if data.get(name)]
        notes += [f"{choices(unchecked)} of the message are not checked"] if unchecked else []
        data = inner[0] if isinstance(inner, list) else inner
    return data, notes


def parse(text: str, where: str) -> Any:
    """Plain data out of JSON text."""
    try:
        return json.loads(text)
    except ValueError as error:
        raise FileError(f"{where} is no JSON: {error}; mend the file.") from None
    except RecursionError:
        raise FileError(f"{where} is nested too deeply to be a joint path; give {_FORMATS}.") from None


def path_in_json(data: Any, where: str) -> PathFile:
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
        data, notes = unwrapped(data, where)
        rows = _rows_of(data, where) if isinstance(data, dict) else None
        if rows is not None:
            return PathFile(matrix(rows, where), joint_names(data, where), _text(data.get("robot")), tuple(notes))
    raise FileError(f"{where} holds no path: give {_FORMATS}.")


def _rows_of(data: dict[str, Any], where: str) -> Any:
    if data.get("path") == [] and data.get("outcome") not in (None, "solved"):
        raise FileError(f"{where} is a plan that found no path (outcome '{data['outcome']}'): there is none to check.")
    if "outcome" in data:  # our own plan.json
        return data.get("path")
    given = [key for key in (*_ROWS, "points") if key in data]
    if not given:
        return None
    require_known(data, _OF_A_PATH, where)
    require_header(data.get("header") or {}, where)
    if len(given) > 1:
        raise FileError(f"{where} holds more than one path ({choices(given)}): leave one.")
    if given == ["points"] and isinstance(data["points"], list):
        return [_positions(point, k, where) for k, point in enumerate(data["points"], 1)]
    return data[given[0]]


def _positions(point: Any, number: int, where: str) -> Any:
    if not isinstance(point, dict):
        return point
    require_known(point, OF_A_POINT, f"{where}: point {number}")
    if "time_from_start" not in point and any(point.get(key) for key in _COLUMNS[1:]):
        raise FileError(f"{where}: point {number} has velocities and no time_from_start; give the time, or neither.")
    return point.get("positions")


def joint_names(data: dict[str, Any], where: str) -> tuple[str, ...] | None:
    """The names of the columns, None where a file gives none."""
    given = [data[key] for key in _NAMES if key in data]
    if len(given) > 1:
        raise FileError(f"{where} names its joints twice ({choices(_NAMES)}): leave one of them.")
    names = given[0] if given else None
    if names is None:
        return None
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise FileError(f"{where}: its joint names are no list of names; mend the file.")
    return tuple(names)


def _text(value: Any) -> str | None:
    return value if isinstance(value, str) else None


def path_in_csv(names: tuple[str, ...] | None, table: list[list[str]], robot: Robot, where: str) -> PathFile:
    """A path out of the rows of a CSV without times."""
    if names is not None:
        require_columns(names, table, robot, where)
        rate = next((name for name in names if name.endswith(ENDINGS)), None)
        if rate is not None:
            raise FileError(f"{where} has a column '{rate}' and no times: give a column {TIME} (s), or leave it out.")
    return PathFile(matrix(table, where), names)


def csv_table(text: str, where: str) -> tuple[tuple[str, ...] | None, list[list[str]]]:
    """The names in the first line of a CSV, None where it holds numbers, and the rows of text."""
    try:
        table = [[cell.strip() for cell in row] for row in csv.reader(text.removeprefix("\ufeff").splitlines()) if row]
    except csv.Error as error:
        raise FileError(f"{where} is not valid CSV: {error}; mend the file.") from None
    if not table or all(map(_is_number, table[0])):
        return None, table
    return tuple(table[0]), table[1:]


def require_columns(names: Sequence[str], table: Sequence[Sequence[str]], robot: Robot, where: str) -> None:
    """Raise :class:`FileError` for names that no reader knows, are repeated, or do not fit the rows of a ``table``."""
    joints = (*robot.joints, *robot.fixed_joints)
    require_known(
        names, (TIME, *joints, *(joint + ending for joint in joints for ending in ENDINGS)), where, "a column"
    )
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise FileError(f"{where} has two columns {choices(twice)}: leave one of them.")
    other = next((len(row) for row in table if len(row) != len(names)), None)
    if other is not None:
        raise FileError(f"{where} names {len(names)} columns and has {other}: mend the file.")


def _is_number(text: str) -> bool:
    try:
        number(text)
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
    return number(cell) if isinstance(cell, str) else float(cell)
