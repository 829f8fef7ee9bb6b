"""Trajectories out of files of any origin, and what a controller makes of their points."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

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
    left_out,
    matrix,
    parse,
    require_columns,
)
from planner.trajectory.ros_bag import read_bag
from planner.trajectory.trajectory import Trajectory, whole_nanoseconds

_AT_REST = float(np.finfo(np.float32).eps)  # rad/s: what ROS 2's controller lets a trajectory end with


@dataclass(frozen=True, eq=False)
class Points:
    """A trajectory as a file has it: ``times`` (k,) s, and positions, perhaps velocities and accelerations (k, dof).

    Joints are in the robot's order. The times may be of no use; :meth:`fault` says so. ``notes`` say what of the file
    is left aside.
    """

    joints: tuple[str, ...]
    times: Floats
    columns: tuple[Floats, ...]
    limits: MotionLimits | None = None  # that the file says it was made for
    notes: tuple[str, ...] = ()

    def fault(self) -> str | None:
        """Why no controller runs these times and velocities, as part of a sentence; None where one does."""
        late = np.flatnonzero(np.diff(whole_nanoseconds(self.times)) <= 0)
        if len(late):
            k = int(late[0])
            between = f"from point {k + 1} to point {k + 2} ({self.times[k]:.10g} s, {self.times[k + 1]:.10g} s)"
            return f"time does not increase {between}"
        if self.times[0] < 0:
            return f"the first point is {-self.times[0]:g} s before the start"
        if len(self.columns) > 1 and np.abs(self.columns[1][-1]).max() > _AT_REST:
            joint = int(np.abs(self.columns[1][-1]).argmax())
            return (
                f"the last velocity is not 0: joint '{self.joints[joint]}' ends with {self.columns[1][-1, joint]:.3g}, "
                "which a ROS 2 joint trajectory controller refuses"
            )
        return None

    def beginning(self) -> tuple[str, ...]:
        """What is to be said of how it begins: what comes before is the controller's, and nothing is known of it."""
        found = []
        if self.times[0] > 0:
            found.append(f"until {self.times[0]:g} s it moves there from where the robot is: that is not checked")
        velocity = self.columns[1][0] if len(self.columns) > 1 else np.zeros(len(self.joints))
        joint = int(np.abs(velocity).argmax())
        if abs(velocity[joint]) > _AT_REST:
            moves = f"joint '{self.joints[joint]}' begins with a velocity of {velocity[joint]:.3g}"
            found.append(f"{moves}: right only for a robot that moves so already")
        return tuple(found)

    def trajectory(self) -> Trajectory:
        """What a ROS 2 joint trajectory controller runs: lines, cubics or quintics, by what is given."""
        return Trajectory.through(self.joints, self.times, *self.columns)


def read_points(path: StrPath, robot: Robot) -> Points | None:
    """The trajectory of a file, in the robot's order of joints; None where the file holds a path without times.

    Our own ``trajectory.json`` or its folder; a JointTrajectory, RobotTrajectory or FollowJointTrajectory goal as JSON
    or YAML; a CSV with a column of times; the first JointTrajectory of a bag
    in MCAP. Accelerations make quintics, as in a message; our own file says what its pieces are. Raises
    :class:`FileError` for what cannot be read, and for what nobody knows: each field is honoured, noted or refused.
    """
    path = Path(path)
    path = path / TRAJECTORY_NAME if os.path.isdir(path) else path
    where = f"trajectory {path}"
    data: Any = None  # of JSON
    match path.suffix.lower():
        case ".mcap":
            message, count = read_bag(path, where)
            found = _first_of(points_of(message, where), count, "messages")
        case ".csv":
            found = _from_csv(read_text(path, "joint path"), robot, where)
        case ".yaml" | ".yml":
            text = read_text(path, "trajectory")
            texts = [part for part in text.split("\n---") if part.strip(" -\n")]
            found = _first_of(points_of(parse_yaml("".join(texts[:1]), where), where), len(texts), "documents")
            if found is not None and len(texts) == 1 and text[-1] not in "\n]}":
                found = replace(
                    found, notes=(*found.notes, "the file ends within a line: if it is cut there, so is its last point")
                )
            if found is None:
                raise FileError(f"{where} holds no trajectory: give one with joint_names and points with times.")
        case ".json":
            data = parse(read_text(path, "joint path"), where)
            found = points_of(data, where)
        case _:
            return None
    if found is None:
        return None
    points = _in_order(found, robot, where)
    limits = limits_in(data, where)  # of our own file, whatever it is called by now
    return replace(points, limits=limits if limits is not None and limits.joints == robot.joints else None)


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


def _from_csv(text: str, robot: Robot, where: str) -> Raw | None:
    names, rows = csv_table(text, where)
    if names is None or TIME not in names:
        return None
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
