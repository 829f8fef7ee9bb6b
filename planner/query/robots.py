"""The robot of a request: a URDF is read once a process while its files stand as they are, the same object each time.

What is worked out of a robot, its reaches, hulls and pairs, is kept by the object: so a new scene costs its obstacles.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from planner.base.errors import OptionError
from planner.base.files import StrPath
from planner.base.notes import Note
from planner.problem.request import WorldRequest
from planner.problem.targets import Joints, Target
from planner.query.resolve import looks_like_degrees
from planner.query.sources import Stamp, stamp_of
from planner.robot.files.packages import PATHS
from planner.robot.files.robot_files import JointChoice, RobotFiles, read_robot, robot_file
from planner.robot.files.urdf_geometry import mesh_files
from planner.robot.moveit.message import choice_of, notes_on, start_of
from planner.robot.poses import pose
from planner.robot.robot import Robot, assemble, with_carried, with_tool, with_widened_limits
from planner.robot.scene import Scene

if TYPE_CHECKING:
    from planner.robot.moveit.requests import MotionPlanRequest

_log = logging.getLogger(__name__)

_KEPT = 16  # robots


def robot_of(request: WorldRequest, scene: Scene, message: MotionPlanRequest | None) -> Robot:
    """The robot as the scene and the request set it up; one that is given as such stands as it is."""
    if isinstance(request.robot, Robot):
        _require_as_it_is(request)
        return _asked_of(_carrying(with_tool(request.robot, request.tool), scene), message, JointChoice())
    files = files_of(str(request.robot), request.srdf)
    placement = scene.placement(files.name)
    tool, fixed = request.tool or placement.tool, dict(placement.fixed_joints)
    choice = JointChoice(request.group, request.joints)
    if message is not None:
        choice, start = choice_of(message, choice, files), start_of(message, scene)
        planned = files.planned_joints(tool, choice, fixed)
        free = [name for name in files.model.names[1:] if name in start and name not in planned]
        held = {name: start[name] for name in free if files.description.mimic(name).leader not in planned}
        _log.info("joints that are not planned are held as the request has them: %s", held or "it names none")
        fixed |= held
    base = (
        placement.base.matrix() if request.base is None else pose(request.base[:3], request.base[3:] or (0.0, 0.0, 0.0))
    )
    robot = _assembled(files, tool, choice, tuple(fixed.items()), tuple(np.ravel(base).tolist()))
    return _asked_of(_carrying(robot, scene), message, choice)


def widened_for(robot: Robot, targets: list[Target]) -> Robot:
    """Limits widened to what is asked for in joints, unless that looks like degrees; its notes say which."""
    wanted = [np.array(t.values) for t in targets if isinstance(t, Joints) and len(t.values) == robot.dof]
    wanted = [q for q in wanted if np.isfinite(q).all() and not looks_like_degrees(robot, q)]
    low, high = robot.lower, robot.upper
    for q in wanted:
        low, high = np.minimum(low, q), np.maximum(high, q)
    beyond = np.flatnonzero((low < robot.lower) | (high > robot.upper))
    return _widened(robot, tuple(low.tolist()), tuple(high.tolist())) if len(beyond) else robot


def _require_as_it_is(request: WorldRequest) -> None:
    for option in ("srdf", "group", "joints", "base"):
        if getattr(request, option) is not None:
            raise OptionError(
                f"'{option}' is for a robot given by name or path: give it to Robot.load, which made this one."
            )


_read: dict[tuple[object, ...], tuple[RobotFiles, dict[Path, Stamp | None]]] = {}


def files_of(name: str, srdf: StrPath | None) -> RobotFiles:
    """The robot's files, read again where one of them has changed.

    A xacro or MJCF file is read each time, as it may include files that no list names.
    """
    key = name, srdf, *map(os.environ.get, PATHS)
    files, stamps = _read.get(key, (None, {}))
    if files is None or any(stamp_of(path) != stamp for path, stamp in stamps.items()):
        files = read_robot(name, srdf)
        stamps = {path: stamp_of(path) for path in _paths_of(files)}
        if not any(path.suffix.lower() in (".xacro", ".xml") for path in stamps):
            _read[key] = files, stamps
    return files


def _paths_of(files: RobotFiles) -> Iterator[Path]:
    """All that a robot was read from: robot.yaml or URDF, then URDF, SRDF and meshes."""
    yield from (robot_file(files.origin), files.description.path)
    if files.srdf is not None:
        yield files.srdf.path
    yield from mesh_files(files.description)


@lru_cache(_KEPT)
def _assembled(
    files: RobotFiles,
    tool: str | None,
    choice: JointChoice,
    fixed: tuple[tuple[str, float], ...],
    base: tuple[float, ...],
) -> Robot:
    return assemble(files, tool, choice, dict(fixed), np.reshape(base, (4, 4)))


def _carrying(robot: Robot, scene: Scene) -> Robot:
    return with_carried(robot, scene.carried) if scene.carried else robot


def _asked_of(robot: Robot, message: MotionPlanRequest | None, choice: JointChoice) -> Robot:
    """The robot with the shares of its limits that a request asks for, and notes of what it cannot make use of."""
    if message is None:
        return robot
    return _with_shares(robot, tuple(message.shares.items()), tuple(notes_on(message, robot, choice)))


@lru_cache(_KEPT)
def _with_shares(robot: Robot, shares: tuple[tuple[str, float], ...], notes: tuple[Note, ...]) -> Robot:
    known: Mapping[str, float] = dict(shares)
    return replace(robot, shares=known, notes=(*robot.notes, *notes)) if known != robot.shares or notes else robot


@lru_cache(_KEPT)
def _widened(robot: Robot, low: tuple[float, ...], high: tuple[float, ...]) -> Robot:
    wide = with_widened_limits(robot, np.array([low, high]))
    wider = np.flatnonzero((wide.lower < robot.lower) | (wide.upper > robot.upper))
    told = (f"limits of {robot.joints[k]} widened to [{low[k]:.4f}, {high[k]:.4f}]" for k in wider)
    return replace(wide, notes=(*robot.notes, *map(Note, told)))
