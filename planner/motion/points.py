"""Trajectories out of files of any origin, and what a controller makes of their points."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError
from planner.base.files import is_folder
from planner.base.yamlfile import parse_yaml, read_text
from planner.motion.file import TRAJECTORY_NAME, limits_in
from planner.motion.limits import MotionLimits
from planner.motion.ros_bag import read_bag
from planner.motion.trajectory import DEGREE, Trajectory
from planner.paths.file import PathFile, cells, in_order, is_number, joint_names, matrix, parse, require_no_moving_base
from planner.world.robot import Robot

_TIME = ("t", "time", "time_from_start", "time_s", "seconds")
_ENDINGS = (
    ("_velocity", "_vel", ".velocity", "/velocity"),
    ("_acceleration", "_acc", ".acceleration", "/acceleration"),
)
_OWN = ("q", "qd", "qdd")
_MESSAGE = ("positions", "velocities", "accelerations")
_FAR = 1e6  # rad, rad/s, rad/s², s: no motion of an arm goes there


@dataclass(frozen=True, eq=False)
class Points:
    """A trajectory as a file has it: ``times`` (k,) s, and positions, perhaps velocities and accelerations (k, dof).

    Joints are in the robot's order. The times may be of no use; :meth:`fault` says so.
    """

    joints: tuple[str, ...]
    times: Floats
    columns: tuple[Floats, ...]
    limits: MotionLimits | None = None  # that the file says it was made for

    def fault(self) -> str | None:
        """Why no controller runs these times and velocities, as part of a sentence; None where one does."""
        late = np.flatnonzero(np.diff(self.times) <= 0)
        if len(late):
            k = int(late[0])
            between = f"from point {k + 1} to point {k + 2} ({self.times[k]:g} s, {self.times[k + 1]:g} s)"
            return f"time does not increase {between}"
        if self.times[0] < 0:
            return f"the first point is {-self.times[0]:g} s before the start"
        if len(self.columns) > 1 and np.abs(self.columns[1][-1]).max() > 1e-6:
            joint = int(np.abs(self.columns[1][-1]).argmax())
            return (
                f"the last velocity is not 0: joint '{self.joints[joint]}' ends with {self.columns[1][-1, joint]:.3g}, "
                "which a ROS 2 joint trajectory controller refuses"
            )
        return None

    def trajectory(self) -> Trajectory:
        """What a ROS 2 joint trajectory controller runs: lines, cubics or quintics, by what is given."""
        return Trajectory.through(self.joints, self.times, *self.columns)


def read_points(path: Path, robot: Robot) -> Points | None:
    """The trajectory of a file, in the robot's order of joints; None where the file holds a path without times.

    Our own ``trajectory.json`` or its folder; a JointTrajectory, RobotTrajectory or FollowJointTrajectory goal as JSON
    or YAML; a CSV with a column of times; an ``.npz`` with t, q, perhaps qd and qdd; the
    first JointTrajectory of a bag in MCAP. Accelerations make quintics, as in
    a message; our own file says what its pieces are. Raises :class:`FileError` for what cannot be read.
    """
    path = path / TRAJECTORY_NAME if is_folder(path) else path
    where = f"trajectory {path}"
    match path.suffix.lower():
        case ".npz":
            found = _from_npz(path, where)
        case ".mcap":
            found = _from_data(read_bag(path, where), where)
        case ".csv":
            found = _from_csv(read_text(path, "joint path"), where)
        case ".yaml" | ".yml":
            found = _from_data(parse_yaml(read_text(path, "trajectory").split("\n---")[0], where), where)
            if found is None:
                raise FileError(f"{where} holds no trajectory: give one with joint_names and points with times.")
        case ".json":
            found = _from_data(parse(read_text(path, "joint path"), where), where)
        case _:
            return None
    if found is None:
        return None
    points = _in_order(*found, robot, where)
    own = path.suffix.lower() == ".json" and path.name.endswith(TRAJECTORY_NAME)
    limits = limits_in(parse(read_text(path, "trajectory"), where), where) if own else None
    return replace(points, limits=limits if limits is not None and limits.joints == robot.joints else None)


def _in_order(times: Floats, columns: list[Floats], names: Any, robot_name: Any, robot: Robot, where: str) -> Points:
    ordered = []
    for rows in columns:
        if rows.shape != columns[0].shape:
            raise FileError(f"{where}: velocities or accelerations are not as many as positions; mend the file.")
        ordered.append(frozen(in_order(PathFile(rows, names, robot_name), robot, where)))
    for rows in (times[:, None], *ordered):
        bad = np.argwhere(~(np.abs(rows) <= _FAR))
        if len(bad):
            raise FileError(
                f"{where}: point {bad[0, 0] + 1} holds a number that is not finite or absurd; mend the file."
            )
    if len(times) < 2:
        raise FileError(f"{where} holds one point: a trajectory has two or more.")
    return Points(robot.joints, frozen(times), tuple(ordered))


def _from_data(data: Any, where: str) -> tuple[Floats, list[Floats], Any, Any] | None:
    """Times, columns, names and the robot's name out of plain data; None where it has no points with times."""
    if not isinstance(data, dict):
        return None
    require_no_moving_base(data, where)
    for key in ("goal", "trajectory", "joint_trajectory"):
        inner = data.get(key)
        inner = inner[0] if isinstance(inner, list) and len(inner) == 1 else inner
        if isinstance(inner, dict):
            return _from_data(inner, where)
    points = data.get("points")
    if not isinstance(points, list) or not points or not all(isinstance(point, dict) for point in points):
        return None
    own = "q" in points[0]
    if not all("t" in point if own else "time_from_start" in point for point in points):
        return None
    times = np.array([_seconds(point["t" if own else "time_from_start"], where) for point in points])
    keys = _OWN[: _given(data.get("interpolation"))] if own else _MESSAGE
    columns = [rows for key in keys if (rows := _column(points, key, where)) is not None]
    name = data.get("robot") if own else None
    return times, columns, joint_names(data, where), name if isinstance(name, str) else None


def _given(interpolation: Any) -> int:
    """How many of position, velocity and acceleration the pieces of our own file go through."""
    return (DEGREE[interpolation] + 1) // 2 if isinstance(interpolation, str) and interpolation in DEGREE else 2


def _column(points: list[dict[str, Any]], key: str, where: str) -> Floats | None:
    """The rows under a key of all points; None where none has it."""
    has = [bool(point.get(key)) for point in points]
    if not any(has) and key not in ("q", "positions"):
        return None
    if not all(has):
        raise FileError(f"{where}: point {has.index(False) + 1} has no {key}, others have: give all or none of them.")
    return matrix([point[key] for point in points], where)


def _seconds(value: Any, where: str) -> float:
    """A duration as a ROS 1 or ROS 2 message has it, or a number of seconds."""
    try:
        if isinstance(value, dict):
            whole, part = (value.get(a, value.get(b, 0)) for a, b in (("sec", "secs"), ("nanosec", "nsecs")))
            return float(int(whole)) + float(int(part)) * 1e-9
        if not isinstance(value, bool):
            return float(value)
    except (TypeError, ValueError, OverflowError):
        pass
    raise FileError(f"{where}: {json.dumps(value)[:100]} is no time; give sec and nanosec, or seconds.")


def _from_csv(text: str, where: str) -> tuple[Floats, list[Floats], Any, Any] | None:
    lines = [line.strip() for line in text.lstrip("\ufeff").splitlines() if line.strip()]
    names = cells(lines[0].lstrip("# ")) if lines else []
    clock = next((names.index(name) for name in _TIME if name in names), None)
    if clock is None:
        return None
    table = matrix(
        [[c if is_number(c) else "nan" for c in cells(line)] for line in lines[1:] if not line.startswith("#")], where
    )
    if table.shape[1] != len(names):
        raise FileError(f"{where} names {len(names)} columns and has {table.shape[1]}: mend the file.")
    joints = [name for name in names if not name.endswith((*_ENDINGS[0], *_ENDINGS[1])) and name not in _TIME]
    columns = [table[:, [names.index(joint) for joint in joints]]]
    for endings in _ENDINGS:
        found = [next((names.index(j + e) for e in endings if j + e in names), None) for j in joints]
        if all(k is None for k in found):
            break  # accelerations without velocities are of no use
        columns.append(np.stack([np.zeros(len(table)) if k is None else table[:, k] for k in found], axis=1))
    return table[:, clock], columns, tuple(joints), None


def _from_npz(path: Path, where: str) -> tuple[Floats, list[Floats], Any, Any]:
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            content = {key: file[key] for key in ("t", *_OWN, "joints") if key in file}
            given = _OWN[: next((k for k, key in enumerate(_OWN) if key not in content), len(_OWN))] or _OWN[:1]
            times, *columns = (content[key].astype(float, casting="same_kind") for key in ("t", *given))
            names = tuple(map(str, content["joints"].tolist())) if "joints" in content else None
    except FileNotFoundError:
        raise FileError(f"{where} not found: check the path.") from None
    except Exception as error:  # of zip, zlib, NumPy and of their underlying files: of many kinds
        raise FileError(f"{where} is no .npz with t, q and qd: {type(error).__name__}; mend the file.") from None
    if times.ndim != 1 or columns[0].ndim != 2 or len(columns[0]) != len(times):
        raise FileError(f"{where}: t has to be (k,) and q (k, joints); mend the file.")
    return times, columns, names, None
