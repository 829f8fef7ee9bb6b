"""Motions out of files of any origin: our own, rows, ROS messages, CSV, bags; each field is honoured or refused."""

import csv
import logging
import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pydantic

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError, choices
from planner.base.files import StrPath
from planner.base.yamlfile import (
    Number,
    Strict,
    find_duplicates,
    number,
    parse_yaml,
    quote,
    read_text,
    suggest_name,
    validate,
)
from planner.kinematics.arm import HALF_TURN
from planner.problem.outcome import require_readable_version
from planner.robot.robot import Robot
from planner.trajectory.export import read_bag
from planner.trajectory.file import TRAJECTORY_NAME, TrajectoryFile, parse_json, require_columns
from planner.trajectory.trajectory import Trajectory, trajectory_from_file, trajectory_from_points

_log = logging.getLogger(__name__)

FAR = 1000.0  # rad or m: no arm turns 160 times, and looking along such a path every millimetre would not end
TIME, ENDINGS = "t", ("_velocity", "_acceleration")  # of the columns of a CSV
EVENTS = "events of a task (attach, detach, gripper) are not followed: check the plan.json that it was written with"
_FORMATS = "a plan.json, a list of rows, {joints, path}, {joint_names, points} or a CSV"
_ROWS = ("path", "waypoints", "positions", "points")
_TOLERANCES = ("path_tolerance", "goal_tolerance", "component_path_tolerance", "component_goal_tolerance")
_UNCHECKED = (*_TOLERANCES, "goal_time_tolerance", "trajectory_start")
_SEVERAL = ("multi_dof_trajectory", "multi_dof_joint_trajectory")
_WRAPPERS = {  # what stands beside a message in what wraps it, as ROS names it
    "goal": ("goal_id", "header"),
    "trajectory": (*_UNCHECKED, "multi_dof_trajectory", "model_id"),
    "joint_trajectory": ("multi_dof_joint_trajectory",),
}


def _seconds(value: Any) -> Any:
    """Seconds of a duration as a ROS 2 (sec, nanosec) or ROS 1 (secs, nsecs) message has it; numbers as they are."""
    if not isinstance(value, dict):
        return value
    names = next((names for names in (("sec", "nanosec"), ("secs", "nsecs")) if value and set(value) <= {*names}), ())
    parts = [value.get(name, 0) for name in names]
    whole = all(not isinstance(part, bool) and isinstance(part, int | float) and part % 1 == 0 for part in parts)
    if not names or not whole or abs(parts[0]) >= 2**31 or not 0 <= parts[1] < 10**9:
        raise ValueError("give whole sec (below 2^31) and nanosec (0 to 999999999), or seconds")
    return (int(parts[0]) * 10**9 + int(parts[1])) / 10**9


class _Header(Strict):
    seq: Any = None
    stamp: Any = None
    frame_id: Any = None


class _Point(Strict):
    positions: list[Number]
    velocities: list[Number] | None = None
    accelerations: list[Number] | None = None
    effort: list[Number] | None = None
    time_from_start: Annotated[Number, pydantic.BeforeValidator(_seconds)] | None = None


class _Message(Strict):
    """A trajectory_msgs/JointTrajectory; without any times it is a path."""

    header: _Header | None = None
    joint_names: list[str] | None = None
    points: list[_Point] = pydantic.Field(min_length=1)


class _Path(Strict):
    """Rows under one of four keys, and joints under one of two."""

    joints: list[str] | None = None
    joint_names: list[str] | None = None
    path: list[list[Number]] | None = None
    waypoints: list[list[Number]] | None = None
    positions: list[list[Number]] | None = None
    points: list[list[Number]] | None = None
    robot: str | None = None
    scene: Any = None
    header: _Header | None = None
    format_version: Any = None


def read_motion(path: StrPath, robot: Robot, data: Any = None) -> Floats | Trajectory:
    """The path (k, dof) or the trajectory of a file, in the robot's order of joints; ``data`` of JSON that is parsed.

    Our own files or the folder of a ``trajectory.json``; a JointTrajectory, RobotTrajectory or FollowJointTrajectory
    goal, or rows, as JSON or YAML; a CSV, with times where it has a column of these; the first JointTrajectory of a bag
    in MCAP. Accelerations make quintics, as in a message; our own file says what its pieces are. Columns of joints that
    are not planned are left out, with a note. Raises :class:`FileError` for content that cannot be read, or has a field
    that is not known.
    """
    path = Path(path)
    path = path / TRAJECTORY_NAME if os.path.isdir(path) else path
    where, notes = f"motion {path}", list[str]()
    match path.suffix.lower():
        case ".mcap":
            data, count = read_bag(path, where)
            notes += [f"the first of {count} messages is looked at"] if count > 1 else []
        case ".yaml" | ".yml":
            data, notes = _from_yaml(read_text(path, "motion"), where)
        case ".csv":
            return _from_csv(read_text(path, "motion"), robot, where)
        case ".json":
            data = parse_json(read_text(path, "motion"), where) if data is None else data
        case _ if not path.exists():
            raise FileError(f"{where} not found: check the path.")
        case other:
            raise FileError(f"{where} ends in '{other}': give a .json, .yaml, .csv or .mcap file.")
    return _from_data(data, notes, robot, where)


def _from_yaml(text: str, where: str) -> tuple[Any, list[str]]:
    """The first document, with notes on others and on an end within a line."""
    texts = [part for part in text.split("\n---") if part.strip(" -\n")]
    data, cut = parse_yaml("".join(texts[:1]), where), len(texts) == 1 and text[-1] not in "\n]}"
    notes = [f"the first of {len(texts)} documents is looked at"] if len(texts) > 1 else []
    return data, notes + ["the file ends within a line: if it is cut there, so is its last point"] * cut


def _from_data(data: Any, notes: list[str], robot: Robot, where: str) -> Floats | Trajectory:
    if isinstance(data, dict):
        require_readable_version(data, where)
        if "intervals" in data:
            raise FileError(
                f"{where} is a sweep, one path an interval of beta: save the 'path' of one of its intervals as a file "
                "of its own, or plan with 'planner plan --beta'."
            )
        if "outcome" in data:  # our own plan.json
            if not data.get("path"):
                raise FileError(f"{where} is a plan that found no path (outcome '{data['outcome']}'): plan again.")
            data = {key: data.get(key) for key in ("joints", "path", "robot")}
        data = _unwrap(data, notes, where)
    if isinstance(data, list):
        data = {"path": data}
    if not isinstance(data, dict) or not any(key in data for key in _ROWS):
        raise FileError(f"{where} holds no path: give {_FORMATS}.")
    points = data.get("points")
    if isinstance(points, str) or (isinstance(points, list) and "..." in points):
        raise FileError(f"{where} lacks points that 'ros2 topic echo' left out: write it with --full-length.")
    if not isinstance(points, list) or not all(isinstance(point, dict) for point in points):
        return _from_rows(validate(_Path, data, where), notes, robot, where)
    if any("q" in point or "t" in point for point in points):
        return _from_own(validate(TrajectoryFile, data, where), notes, robot, where)
    return _from_message(validate(_Message, data, where), notes, robot, where)


def _unwrap(data: Any, notes: list[str], where: str) -> Any:
    """The innermost message of what ROS wraps it in; ``notes`` gain what is to be said of what stands beside it."""
    while isinstance(data, dict) and not any(key in data for key in _ROWS):
        key = next((key for key in _WRAPPERS if isinstance(data.get(key), dict | list)), None)
        if key is None:
            break
        inner = data[key] if isinstance(data[key], list) else [data[key]]
        _require_known(data, (key, *_WRAPPERS[key]), where, "a key")
        if len(inner) != 1:
            raise FileError(f"{where} holds {len(inner)} trajectories: give each in a file of its own.")
        for other in _SEVERAL:
            if isinstance(data.get(other), dict) and data[other].get("points"):
                raise FileError(f"{where} moves joints of several degrees of freedom ({other}): leave these out.")
        unchecked = [name for name in _UNCHECKED if data.get(name)]
        notes += [f"{choices(unchecked)} of the message are not checked"] if unchecked else []
        data = inner[0]
    return data


def _from_own(file: TrajectoryFile, notes: list[str], robot: Robot, where: str) -> Trajectory:
    """The trajectory with its joints in the robot's order; its limits where they are of these."""
    found = trajectory_from_file(file, where)
    columns = [_in_order(rows, found.joints, robot, where, file.robot) for rows in found.columns]
    limits = found.limits if found.joints == robot.joints else None
    notes = [*notes, *([EVENTS] if found.events else []), *_left_out(found.joints, robot)]
    return replace(found, joints=robot.joints, columns=tuple(columns), limits=limits, notes=tuple(notes))


def _from_message(message: _Message, notes: list[str], robot: Robot, where: str) -> Floats | Trajectory:
    """A trajectory, a path where no point has a time."""
    points, names = message.points, message.joint_names
    times = [point.time_from_start for point in points]
    if all(time is None for time in times):
        if any(point.velocities or point.accelerations or point.effort for point in points):
            raise FileError(f"{where} has points with velocities and no time_from_start; give times, or neither.")
        return _joint_path(matrix([point.positions for point in points], where), names, notes, robot, where)
    if None in times:
        raise FileError(f"{where}: point {times.index(None) + 1} has no time_from_start, others have: give it for all.")
    if not names:
        raise FileError(f"{where} names no joints, which a joint trajectory controller refuses: add joint_names.")
    stamp = message.header and message.header.stamp
    if any(stamp.values()) if isinstance(stamp, dict) else stamp:
        notes.append("the header's stamp, when a controller is to begin, is not looked at")
    if any(point.effort for point in points):
        notes.append("effort is not checked, and refused by a controller that does not command it")
    kinds = ("positions", "velocities", "accelerations")
    rows = require_columns([[getattr(point, kind) for point in points] for kind in kinds], len(names), where)
    columns = [_in_order(each, names, robot, where) for each in rows]
    told = (*notes, *_left_out(names, robot))
    return trajectory_from_points(robot.joints, np.array(times, dtype=float), columns, where, notes=told)


def _from_rows(file: _Path, notes: list[str], robot: Robot, where: str) -> Floats:
    given = [key for key in _ROWS if getattr(file, key) is not None]
    if len(given) != 1:
        raise FileError(f"{where} must hold one path, got {choices(given) or 'none'}: leave one.")
    if file.joints is not None and file.joint_names is not None:
        raise FileError(f"{where} names its joints twice (joints, joint_names): leave one of them.")
    names = file.joint_names if file.joints is None else file.joints
    return _joint_path(matrix(getattr(file, given[0]), where), names, notes, robot, where, file.robot)


def _from_csv(text: str, robot: Robot, where: str) -> Floats | Trajectory:
    names, table = csv_table(text, where)
    if names is None:
        return _joint_path(matrix(table, where), None, [], robot, where)
    joints = (*robot.joints, *robot.fixed_joints)
    rates = [joint + ending for joint in joints for ending in ENDINGS]
    _require_known(names, (TIME, *joints, *rates), where, "a column")
    if twice := find_duplicates(names):
        raise FileError(f"{where} has two columns {choices(twice)}: leave one of them.")
    rows = matrix(table, where, len(names))
    if not len(rows):
        raise FileError(f"{where} holds no rows: give at least one configuration.")
    by_name = dict(zip(names, rows.T, strict=True))
    columns = [{name: by_name[name] for name in joints if name in by_name}]
    for ending in ENDINGS:
        columns.append({name: by_name[name + ending] for name in joints if name + ending in by_name})
    if TIME not in names:
        if any(columns[1:]):
            raise FileError(f"{where} has columns of velocities and no times: give a column {TIME} (s), or neither.")
        return _joint_path(rows, names, [], robot, where)
    if columns[2] and not columns[1]:
        raise FileError(f"{where} gives accelerations and no velocities: give velocities too, or neither.")
    ordered = [_in_order(np.array([*each.values()]).T, [*each], robot, where) for each in columns if each]
    return trajectory_from_points(
        robot.joints, by_name[TIME], ordered, where, notes=tuple(_left_out([*columns[0]], robot))
    )


def _joint_path(
    rows: Floats, names: Sequence[str] | None, notes: list[str], robot: Robot, where: str, owner: str | None = None
) -> Floats:
    """The joint path (k, dof) in the robot's order of joints, rad (m where prismatic); notes are warnings.

    Continuous joints are unwound: each step is below half a turn.
    """
    rows = _in_order(rows, names, robot, where, owner)
    for note in (*notes, *_left_out(names, robot)):
        _log.warning("%s: %s", where, note)
    require_plausible(rows, robot, where)
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


def require_plausible(rows: Floats, robot: Robot, where: str) -> None:
    """Raise :class:`FileError` for values (k, dof) that are not finite, or that no joint ever has."""
    for row, joint in np.argwhere(~(np.abs(rows) <= FAR))[:1]:
        raise FileError(
            f"{where}: row {row + 1} puts joint '{robot.joints[joint]}' at {rows[row, joint]:g}, beyond any joint's "
            f"{FAR:g}; mend the file."
        )


def _in_order(rows: Floats, names: Sequence[str] | None, robot: Robot, where: str, owner: str | None = None) -> Floats:
    """The rows with their columns in the robot's order of joints; :class:`FileError` where that cannot be."""
    if owner not in (None, robot.name):
        raise FileError(f"{where} is for robot {quote(owner)}, not '{robot.name}': choose it with --robot.")
    if not len(rows):
        raise FileError(f"{where} holds no rows: give at least one configuration.")
    if names is None:
        if rows.shape[1] != robot.dof:
            raise FileError(
                f"{where} has {rows.shape[1]} columns without names, {robot.name} has {robot.dof} planned joints "
                f"({choices(robot.joints)}): give one column each, or name the columns."
            )
        return rows
    if len(names) != rows.shape[1]:
        raise FileError(f"{where} names {len(names)} columns and has {rows.shape[1]}: mend the file.")
    for joint in robot.joints:
        if names.count(joint) != 1:
            often = "twice" if joint in names else "nowhere"
            raise FileError(
                f"{where} names joint '{joint}' {often}; it names {choices(names)}: choose another --robot, or mend "
                "the file."
            )
    return rows[:, [names.index(joint) for joint in robot.joints]]


def _left_out(names: Sequence[str] | None, robot: Robot) -> list[str]:
    """What is to be said of columns that belong to no planned joint."""
    others = [name for name in names or () if name not in robot.joints]
    if not others:
        return []
    still = ", which stay where the robot has them" if set(others) <= set(robot.fixed_joints) else ""
    still = ", which follow planned ones" if {*others} <= {item.joint for item in robot.followers} else still
    return [f"positions of {choices(others)} are left out: these are no planned joints of {robot.name}{still}"]


def _require_known(keys: Iterable[Any], known: Sequence[str], where: str, what: str) -> None:
    """Raise :class:`FileError` for a key that is not known: what is left aside may be what matters."""
    for key in keys:
        if key not in known:
            meant = suggest_name(str(key), known)
            raise FileError(
                f"{where} has {what} {quote(key)} that is not known{meant}; known are {choices(known)}: rename it, or "
                "leave it out."
            )


def csv_table(text: str, where: str) -> tuple[tuple[str, ...] | None, list[list[str]]]:
    """The names in the first line of a CSV, None where it holds numbers, and the rows of text."""
    try:
        table = [[cell.strip() for cell in row] for row in csv.reader(text.removeprefix("\ufeff").splitlines()) if row]
    except csv.Error as error:
        raise FileError(f"{where} is not valid CSV: {error}; mend the file.") from None
    try:
        for cell in table[0] if table else ():
            number(cell)
    except ValueError:
        return tuple(table[0]), table[1:]
    return None, table


def matrix(rows: list[list[Any]], where: str, width: int | None = None) -> Floats:
    """Rows of numbers, or of their text, as an array (k, width); that of the first row where left out."""
    width = len(rows[0]) if rows and width is None else width
    values = np.zeros((len(rows), width or 0))
    for k, row in enumerate(rows):
        if len(row) != width:
            raise FileError(f"{where}: row {k + 1} has {len(row)} values, not {width}; mend the file.")
        try:
            values[k] = [number(cell) if isinstance(cell, str) else cell for cell in row]
        except ValueError:
            raise FileError(f"{where}: row {k + 1} holds something that is no number; mend the file.") from None
    return values
