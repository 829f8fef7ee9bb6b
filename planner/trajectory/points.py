"""Paths and trajectories out of files of any origin, each file parsed once."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError, choices
from planner.base.files import StrPath
from planner.base.yamlfile import parse_yaml, read_text
from planner.robot.robot import Robot
from planner.trajectory.file import TRAJECTORY_NAME, limits_in, require_near
from planner.trajectory.limits import MotionLimits
from planner.trajectory.messages import Raw, as_columns, points_of
from planner.trajectory.path_file import (
    ENDINGS,
    TIME,
    PathFile,
    csv_table,
    in_order,
    joint_path,
    left_out,
    matrix,
    parse,
    path_in_csv,
    path_in_json,
    require_columns,
)
from planner.trajectory.ros_bag import read_bag
from planner.trajectory.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Points:
    """A trajectory as a file has it: ``times`` (k,) s, and positions, perhaps velocities and accelerations (k, dof).

    Joints are in the robot's order. No controller may run the times. ``limits`` are those that the file was made for,
    ``notes`` name what is left out.
    """

    joints: tuple[str, ...]
    times: Floats
    columns: tuple[Floats, ...]
    limits: MotionLimits | None = None
    notes: tuple[str, ...] = ()

    def trajectory(self) -> Trajectory:
        """What a ROS 2 joint trajectory controller runs: lines, cubics or quintics, by what is given."""
        return Trajectory.through(self.joints, self.times, *self.columns)


def read_motion(path: StrPath, robot: Robot, data: Any = None) -> Floats | Points:
    """The path (k, dof) or the trajectory of a file, in the robot's order of joints; ``data`` of JSON that is parsed.

    Our own files or the folder of a ``trajectory.json``; a JointTrajectory, RobotTrajectory or FollowJointTrajectory
    goal as JSON or YAML; a list of rows; a CSV, with times where it has a column of these; the first JointTrajectory of
    a bag in MCAP. Accelerations make quintics, as in a message; our own file says what its pieces are. Raises
    :class:`FileError` for content that cannot be read, or has a field that is not known.
    """
    path = Path(path)
    path = path / TRAJECTORY_NAME if os.path.isdir(path) else path
    where, path_where = f"trajectory {path}", f"joint path {path}"
    match path.suffix.lower():
        case ".mcap":
            message, count = read_bag(path, where)
            found = _first_of(points_of(message, where), count, "messages")
        case ".yaml" | ".yml":
            found = _from_yaml(read_text(path, "trajectory"), where)
        case ".csv":
            names, table = csv_table(read_text(path, "joint path"), where)
            if names is None or TIME not in names:
                return joint_path(path_in_csv(names, table, robot, path_where), robot, path_where)
            found = _from_csv(names, table, robot, where)
        case ".json":
            data = parse(read_text(path, "joint path"), path_where) if data is None else data
            found = points_of(data, where)
            if found is None:
                return joint_path(path_in_json(data, path_where), robot, path_where)
        case _ if not path.exists():
            raise FileError(f"{path_where} not found: check the path.")
        case other:
            raise FileError(f"{path_where} ends in '{other}': give a .json, .yaml, .csv or .mcap file.")
    if found is None:
        raise FileError(f"{where} holds no trajectory: give one with joint_names and points with times.")
    limits = limits_in(data, where)  # of our own file, whatever its name is
    known = limits is not None and limits.joints == robot.joints
    return replace(_in_order(found, robot, where), limits=limits if known else None)


def _from_yaml(text: str, where: str) -> Raw | None:
    """The first document, with notes on others and on an end within a line."""
    texts = [part for part in text.split("\n---") if part.strip(" -\n")]
    found = _first_of(points_of(parse_yaml("".join(texts[:1]), where), where), len(texts), "documents")
    if found is None or len(texts) != 1 or text[-1] in "\n]}":
        return found
    return replace(found, notes=(*found.notes, "the file ends within a line: if it is cut there, so is its last point"))


def _first_of(found: Raw | None, count: int, of: str) -> Raw | None:
    """With a note where a file holds more than one."""
    if found is None or count < 2:
        return found
    return replace(found, notes=(f"the first of {count} {of} is looked at", *found.notes))


def _in_order(found: Raw, robot: Robot, where: str) -> Points:
    ordered, times = [], found.times
    for rows in found.columns:
        if rows.shape != found.columns[0].shape:
            raise FileError(f"{where}: velocities or accelerations are not as many as positions; mend the file.")
        ordered.append(frozen(in_order(PathFile(rows, found.names, found.robot), robot, where)))
    for rows in (times[:, None], *ordered):
        require_near(rows, where)
    if len(times) < 2:
        raise FileError(f"{where} holds one point: a trajectory has two or more.")
    notes = (*found.notes, *left_out(found.names, robot))
    return Points(robot.joints, frozen(times), tuple(ordered), notes=notes)


def _from_csv(names: tuple[str, ...], rows: list[list[str]], robot: Robot, where: str) -> Raw:
    require_columns(names, rows, robot, where)
    table = matrix(rows, where)
    joints = tuple(name for name in names if name in {*robot.joints, *robot.fixed_joints})
    positions = in_order(PathFile(table[:, [names.index(joint) for joint in joints]], joints), robot, where)
    given = [positions, *(_of_kind(ending, names, table, robot, where) for ending in ENDINGS)]
    return Raw(
        table[:, names.index(TIME)], as_columns(given, where), robot.joints, None, tuple(left_out(joints, robot))
    )


def _of_kind(ending: str, names: tuple[str, ...], table: Floats, robot: Robot, where: str) -> Floats | None:
    """The columns (k, dof) of joint names with an ``ending``, in the robot's order; None where there are none."""
    wanted = [joint + ending for joint in robot.joints]
    missing = [name for name in wanted if name not in names]
    if len(missing) == len(wanted):
        return None
    if missing:
        raise FileError(f"{where} has no column {choices(missing)}: give one for each joint, or none.")
    return table[:, [names.index(name) for name in wanted]]
