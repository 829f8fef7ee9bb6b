"""Motions of files of any origin: our own, rows, ROS messages, CSV, bags; unknown fields are refused."""

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

FAR = 1000.0  # rad or m: beyond any arm (160 turns); sampling such a path every millimetre would not end
TIME, ENDINGS = "t", ("_velocity", "_acceleration")  # of the columns of a CSV
EVENTS = "events of a task (attach, detach, gripper) are ignored: check the task's plan.json instead"
_FORMATS = "a plan.json, a list of rows, {joints, path}, {joint_names, points} or a CSV"
_ROWS = ("path", "waypoints", "positions", "points")
_TOLERANCES = ("path_tolerance", "goal_tolerance", "component_path_tolerance", "component_goal_tolerance")
_UNCHECKED = (*_TOLERANCES, "goal_time_tolerance", "trajectory_start")
_PLANNED = ("group_name", "planning_time", "error_code")  # of a MotionPlanResponse
_SEVERAL = ("multi_dof_trajectory", "multi_dof_joint_trajectory")
_WRAPPERS = {  # keys of ROS messages next to the wrapped one
    "goal": ("goal_id", "header"),
    "trajectory": (*_UNCHECKED, *_PLANNED, "multi_dof_trajectory", "model_id"),
    "joint_trajectory": ("multi_dof_joint_trajectory",),
}


def _seconds(value: Any) -> Any:
    """Return the seconds of a ROS 2 (sec, nanosec) or ROS 1 (secs, nsecs) duration; numbers unchanged."""
    if not isinstance(value, dict):
        return value
    names = next((names for names in (("sec", "nanosec"), ("secs", "nsecs")) if value and set(value) <= {*names}), ())
    parts = [value.get(name, 0) for name in names]
    integral = all(not isinstance(part, bool) and isinstance(part, int | float) and part % 1 == 0 for part in parts)
    if not names or not integral or abs(parts[0]) >= 2**31 or not 0 <= parts[1] < 10**9:
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
    """A trajectory_msgs/JointTrajectory; without times it is a path."""

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
    """Return the path (k, dof) or the trajectory of a file, in the robot's order of joints.

    It reads our own files and the folder of a ``trajectory.json``; JointTrajectory, FollowJointTrajectory goals,
    MoveIt's RobotTrajectory, DisplayTrajectory and MotionPlanResponse, and rows as JSON or YAML; CSV, optionally with
    times; the first JointTrajectory, RobotTrajectory or DisplayTrajectory of an MCAP bag. ``data`` is JSON parsed
    before. Accelerations make quintics, as in a message; our own file names its interpolation. Columns of joints that
    are not planned are ignored, with a note. Raises :class:`FileError` for unreadable content
    and unknown fields.
    """
    path = Path(path)
    path = path / TRAJECTORY_NAME if os.path.isdir(path) else path
    where, notes = f"motion {path}", list[str]()
    match path.suffix.lower():
        case ".mcap":
            data, count = read_bag(path, where)
            notes += [f"only the first of {count} messages is checked"] if count > 1 else []
        case ".yaml" | ".yml":
            data, notes = _from_yaml(read_text(path, "motion"), where)
        case ".csv":
            return _from_csv(read_text(path, "motion"), robot, where)
        case ".json":
            data = parse_json(read_text(path, "motion"), where) if data is None else data
        case _ if not path.exists():
            raise FileError(f"{where} not found: check the path.")
        case other:
            raise FileError(f"{where} must end in .json, .yaml, .csv or .mcap, got '{other}'.")
    return _from_data(data, notes, robot, where)


def _from_yaml(text: str, where: str) -> tuple[Any, list[str]]:
    """Return the first document, with notes on others and on an end within a line."""
    texts = [part for part in text.split("\n---") if part.strip(" -\n")]
    data, cut = parse_yaml("".join(texts[:1]), where), len(texts) == 1 and text[-1] not in "\n]}"
    notes = [f"only the first of {len(texts)} documents is checked"] if len(texts) > 1 else []
    return data, notes + ["the file ends within a line: its last point may be incomplete"] * cut


def _from_data(data: Any, notes: list[str], robot: Robot, where: str) -> Floats | Trajectory:
    if isinstance(data, dict):
        require_readable_version(data, where)
        if "intervals" in data:
            raise FileError(
                f"{where} must hold one path, got a sweep: save the 'path' of one interval as a file, or plan with "
                "'planner plan --beta'."
            )
        if "outcome" in data:  # our own plan.json
            if not data.get("path"):
                raise FileError(f"{where}: path not found (the plan's outcome is '{data['outcome']}'): plan again.")
            data = {key: data.get(key) for key in ("joints", "path", "robot")}
        data = _unwrap(data, notes, where)
    if isinstance(data, list):
        data = {"path": data}
    if not isinstance(data, dict) or not any(key in data for key in _ROWS):
        raise FileError(f"{where}: path not found: give {_FORMATS}.")
    points = data.get("points")
    if isinstance(points, str) or (isinstance(points, list) and "..." in points):
        raise FileError(
            f"{where}: points must be complete, got '...' of 'ros2 topic echo': write it with --full-length."
        )
    if not isinstance(points, list) or not all(isinstance(point, dict) for point in points):
        return _from_rows(validate(_Path, data, where), notes, robot, where)
    if any("q" in point or "t" in point for point in points):
        return _from_own(validate(TrajectoryFile, data, where), notes, robot, where)
    return _from_message(validate(_Message, data, where), notes, robot, where)


def _unwrap(data: Any, notes: list[str], where: str) -> Any:
    """Return the innermost message of its ROS wrappers; ``notes`` gains remarks on their other keys."""
    while isinstance(data, dict) and not any(key in data for key in _ROWS):
        key = next((key for key in _WRAPPERS if isinstance(data.get(key), dict | list)), None)
        if key is None:
            break
        inner = data[key] if isinstance(data[key], list) else [data[key]]
        _require_keys(data, (key, *_WRAPPERS[key]), where, "key")
        if len(inner) != 1:
            raise FileError(f"{where} must hold one trajectory, got {len(inner)}: give each in a file of its own.")
        for other in _SEVERAL:
            if isinstance(data.get(other), dict) and data[other].get("points"):
                raise FileError(f"{where}: joints must have one degree of freedom, got {other}: leave it out.")
        unchecked = [name for name in _UNCHECKED if data.get(name)]
        notes += [f"{choices(unchecked)} of the message are not checked"] if unchecked else []
        data = inner[0]
    return data


def _from_own(file: TrajectoryFile, notes: list[str], robot: Robot, where: str) -> Trajectory:
    """Return the trajectory with its joints in the robot's order; its limits only for the same joints."""
    trajectory = trajectory_from_file(file, where)
    joints = trajectory.joints
    columns = [_reorder(rows, joints, robot, where, file.robot) for rows in trajectory.columns]
    limits = trajectory.limits if joints == robot.joints else None
    notes = [*notes, *([EVENTS] if trajectory.events else []), *_note_other_columns(joints, robot)]
    return replace(trajectory, joints=robot.joints, columns=tuple(columns), limits=limits, notes=tuple(notes))


def _from_message(message: _Message, notes: list[str], robot: Robot, where: str) -> Floats | Trajectory:
    """Return a trajectory, or a path if no point has a time."""
    points, names = message.points, message.joint_names
    times = [point.time_from_start for point in points]
    if all(time is None for time in times):
        if any(point.velocities or point.accelerations or point.effort for point in points):
            raise FileError(f"{where}: velocities must come with time_from_start, got none; give times, or neither.")
        return _joint_path(matrix([point.positions for point in points], where), names, notes, robot, where)
    if None in times:
        raise FileError(f"{where}: time_from_start of point {times.index(None) + 1} not found: give it for all.")
    if not names:
        raise FileError(f"{where}: joint_names not found: add them, as a joint trajectory controller needs them.")
    stamp = message.header and message.header.stamp
    if any(stamp.values()) if isinstance(stamp, dict) else stamp:
        notes.append("the header's stamp, the start time for a controller, is ignored")
    if any(point.effort for point in points):
        notes.append("effort is not checked; a controller without effort commands refuses it")
    kinds = ("positions", "velocities", "accelerations")
    rows = require_columns([[getattr(point, kind) for point in points] for kind in kinds], len(names), where)
    columns = [_reorder(each, names, robot, where) for each in rows]
    notes += _note_other_columns(names, robot)
    return trajectory_from_points(robot.joints, np.array(times, dtype=float), columns, where, notes=tuple(notes))


def _from_rows(file: _Path, notes: list[str], robot: Robot, where: str) -> Floats:
    keys = [key for key in _ROWS if getattr(file, key) is not None]
    if len(keys) != 1:
        raise FileError(f"{where} must hold one path, got {choices(keys) or 'none'}: leave one.")
    if file.joints is not None and file.joint_names is not None:
        raise FileError(f"{where} must name its joints once, got joints and joint_names: leave one of them.")
    names = file.joint_names if file.joints is None else file.joints
    return _joint_path(matrix(getattr(file, keys[0]), where), names, notes, robot, where, file.robot)


def _from_csv(text: str, robot: Robot, where: str) -> Floats | Trajectory:
    names, table = csv_table(text, where)
    if names is None:
        return _joint_path(matrix(table, where), None, [], robot, where)
    joints = (*robot.joints, *robot.fixed_joints)
    rates = [joint + ending for joint in joints for ending in ENDINGS]
    _require_keys(names, (TIME, *joints, *rates), where, "column")
    if twice := find_duplicates(names):
        raise FileError(f"{where}: columns must differ, got {choices(twice)} twice: leave one of them.")
    rows = matrix(table, where, len(names))
    if not len(rows):
        raise FileError(f"{where}: rows not found: give at least one configuration.")
    by_name = dict(zip(names, rows.T, strict=True))
    columns = [{name: by_name[name] for name in joints if name in by_name}]
    for ending in ENDINGS:
        columns.append({name: by_name[name + ending] for name in joints if name + ending in by_name})
    if TIME not in names:
        if any(columns[1:]):
            raise FileError(f"{where}: velocities must come with times, got none: add a column {TIME} (s), or neither.")
        return _joint_path(rows, names, [], robot, where)
    if columns[2] and not columns[1]:
        raise FileError(f"{where}: accelerations must come with velocities, got none: give both, or neither.")
    ordered = [_reorder(np.array([*each.values()]).T, [*each], robot, where) for each in columns if each]
    return trajectory_from_points(
        robot.joints, by_name[TIME], ordered, where, notes=tuple(_note_other_columns([*columns[0]], robot))
    )


def _joint_path(
    rows: Floats, names: Sequence[str] | None, notes: list[str], robot: Robot, where: str, owner: str | None = None
) -> Floats:
    """Return the joint path (k, dof) in the robot's order, rad (m where prismatic); notes become warnings.

    Continuous joints are unwound: each step is below half a turn.
    """
    rows = _reorder(rows, names, robot, where, owner)
    for note in (*notes, *_note_other_columns(names, robot)):
        _log.warning("%s: %s", where, note)
    require_plausible(rows, robot, where)
    return frozen(np.where(robot.continuous, _unwind(rows, robot, where), rows))  # other joints to the last bit


def _unwind(rows: Floats, robot: Robot, where: str) -> Floats:
    """Return the rows (k, dof) with continuous joints unwound; :class:`FileError` for ambiguous turns.

    Half a turn is ambiguous, and so is a whole turn or more, which wrapped angles never differ by.
    """
    step, shortest = np.diff(rows, axis=0), robot.difference(rows[:-1], rows[1:])
    far = robot.continuous & (np.abs(step) >= HALF_TURN)
    ambiguous = far & ((np.abs(shortest) >= HALF_TURN) | (np.abs(step) >= np.pi + HALF_TURN))
    for row, joint in np.argwhere(ambiguous)[:1]:
        raise FileError(
            f"{where}: joint '{robot.joints[joint]}' must turn by less than half a turn from row {row + 1} to row "
            f"{row + 2}, got {step[row, joint]:.6g} rad, whose direction is ambiguous: add rows between them."
        )
    for row, joint in np.argwhere(far)[:1]:
        more = f", the first of {far.sum()} such steps" if far.sum() > 1 else ""
        _log.warning(
            "%s: from row %d to row %d joint '%s' turns the shorter way, by %.6g rad instead of %.6g%s",
            *(where, row + 1, row + 2, robot.joints[joint], shortest[row, joint], step[row, joint], more),
        )
    return robot.unwound(rows)


def require_plausible(rows: Floats, robot: Robot, where: str) -> None:
    """Raise :class:`FileError` for values (k, dof) that are not finite, or beyond any joint."""
    for row, joint in np.argwhere(~(np.abs(rows) <= FAR))[:1]:
        raise FileError(
            f"{where}: joint '{robot.joints[joint]}' must be within {FAR:g}, got {rows[row, joint]:g} in row "
            f"{row + 1}; mend the file."
        )


def _reorder(rows: Floats, names: Sequence[str] | None, robot: Robot, where: str, owner: str | None = None) -> Floats:
    """Return the rows with columns in the robot's order of joints; :class:`FileError` for other columns."""
    if owner not in (None, robot.name):
        raise FileError(f"{where} must be for robot '{robot.name}', got {quote(owner)}: choose it with --robot.")
    if not len(rows):
        raise FileError(f"{where}: rows not found: give at least one configuration.")
    if names is None:
        if rows.shape[1] != robot.dof:
            raise FileError(
                f"{where} must have {robot.dof} columns, got {rows.shape[1]} without names: give one for each of "
                f"{choices(robot.joints)}, or name the columns."
            )
        return rows
    if len(names) != rows.shape[1]:
        raise FileError(f"{where} must have {len(names)} columns, one per name, got {rows.shape[1]}: mend the file.")
    for joint in robot.joints:
        if names.count(joint) != 1:
            raise FileError(
                f"{where} must name joint '{joint}' once, got {choices(names)}: choose another --robot, or "
                "mend the file."
            )
    return rows[:, [names.index(joint) for joint in robot.joints]]


def _note_other_columns(names: Sequence[str] | None, robot: Robot) -> list[str]:
    """Return a note on columns of joints that are not planned, if there are any."""
    others = [name for name in names or () if name not in robot.joints]
    if not others:
        return []
    reason = ", which are fixed" if set(others) <= set(robot.fixed_joints) else ""
    reason = ", which follow planned ones" if {*others} <= {item.joint for item in robot.followers} else reason
    return [f"positions of {choices(others)} are ignored: {robot.name} does not plan these joints{reason}"]


def _require_keys(keys: Iterable[Any], known: Sequence[str], where: str, kind: str) -> None:
    """Raise :class:`FileError` for an unknown key: ignoring it might ignore something important."""
    for key in keys:
        if key not in known:
            suggestion = suggest_name(str(key), known)
            raise FileError(
                f"{where}: {kind} must be one of {choices(known)}, got {quote(key)}{suggestion}: rename it, or leave "
                "it out."
            )


def csv_table(text: str, where: str) -> tuple[tuple[str, ...] | None, list[list[str]]]:
    """Return the names in the first line of a CSV (None for numbers), and the rows of text."""
    try:
        table = [[cell.strip() for cell in row] for row in csv.reader(text.removeprefix("\ufeff").splitlines()) if row]
    except csv.Error as error:
        raise FileError(f"{where} must be CSV, got an error: {error}; mend the file.") from None
    try:
        for cell in table[0] if table else ():
            number(cell)
    except ValueError:
        return tuple(table[0]), table[1:]
    return None, table


def matrix(rows: list[list[Any]], where: str, width: int | None = None) -> Floats:
    """Return rows of numbers, or of their text, as an array (k, width); by default the first row's width."""
    width = len(rows[0]) if rows and width is None else width
    values = np.zeros((len(rows), width or 0))
    for k, row in enumerate(rows):
        if len(row) != width:
            raise FileError(f"{where}: row {k + 1} must have {width} values, got {len(row)}; mend the file.")
        try:
            values[k] = [number(cell) if isinstance(cell, str) else cell for cell in row]
        except ValueError:
            raise FileError(f"{where}: row {k + 1} must hold numbers, got other text; mend the file.") from None
    return values
