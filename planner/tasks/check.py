"""``planner.check``: a path, a trajectory, a file, a plan or a task checked again, whoever made it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

from planner.base.arrays import Floats, numbers
from planner.base.errors import OptionError
from planner.base.files import StrPath
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import RECHECK
from planner.base.yamlfile import read_text, validate
from planner.collision.checker import CollisionChecker
from planner.planning.result import JSON_NAME, Plan
from planner.problem.options import RobotLike
from planner.problem.request import LimitsRequest, PartialWorld, WorldRequest
from planner.query.query import open_world
from planner.roadmap.storage import world_in
from planner.robot.robot import Robot
from planner.tasks.replay import TaskRecord, check_task
from planner.tasks.result import TaskPlan
from planner.trajectory.check import check_path, check_trajectory, require_step
from planner.trajectory.file import TRAJECTORY_NAME, load_trajectory
from planner.trajectory.limits import MotionLimits, require_of_robot
from planner.trajectory.path_file import FAR, parse
from planner.trajectory.points import Points, read_motion
from planner.trajectory.report import Report
from planner.trajectory.trajectory import Trajectory


def check(
    motion: Floats | Sequence[Sequence[float]] | Trajectory | StrPath | Plan | TaskPlan,
    robot: RobotLike | None = None,
    scene: RobotLike | None = None,
    limits: MotionLimits | LimitsRequest | None = None,
    *,
    checker: CollisionChecker | None = None,
    step: float = RECHECK,
    progress: Progress = QUIET,
) -> Report:
    """The report on a motion: a path (k, dof) in rad, a trajectory, a file or folder, a plan or a planned task.

        report = planner.check("out")
        report.ok, report.proven, report.sentence
        for finding in report.findings: print(finding.sentence)

    Samples are ``step`` metres of motion apart, proofs of whole pieces come on top. ``robot`` and ``scene`` are names,
    files or objects; of a file they are those of the plan.json next to it where they are left out. ``checker`` stands
    for both. ``limits`` are in place of those that a trajectory was made for. Raises :class:`PlannerError` for a motion
    that cannot be read, and :class:`ArrayError` for an array of another shape.
    """
    require_step(step)
    given = PartialWorld(robot=robot, scene=scene)
    if isinstance(motion, str | os.PathLike):
        return check_file(Path(motion), given, limits, step, progress, checker)
    if isinstance(motion, Plan | TaskPlan) and (robot or scene):
        raise OptionError("robot and scene must be those of the plan: leave them out, or check its trajectory.")
    if isinstance(motion, TaskPlan):
        return motion.check(step, checker)
    if isinstance(motion, Plan):
        checker, motion = checker or motion.checker, motion.path if motion.trajectory is None else motion.trajectory
    checker = checker or open_world(with_config(given, {}))
    if isinstance(motion, Trajectory):
        return check_trajectory(checker, motion, _limits(limits, checker.robot), step, progress)
    return check_path(checker, numbers("path", motion, ("k", checker.robot.dof), most=FAR), step, progress)


def check_file(
    path: Path,
    given: PartialWorld,
    limits: MotionLimits | LimitsRequest | None = None,
    step: float = RECHECK,
    progress: Progress = QUIET,
    checker: CollisionChecker | None = None,
) -> Report:
    """The report on a file or the folder of a plan; what ``given`` leaves out is that of the plan.json next to it.

    Raises :class:`OptionError` for ``limits`` of a path without times, or of a task.
    """
    folder = path if os.path.isdir(path) else path.parent
    ours = os.path.isdir(path) or path.name in (JSON_NAME, TRAJECTORY_NAME)
    record = read_record(folder) if ours or given.robot is None or given.scene is None else {}
    config = record.get("config", {})
    world = with_config(given, config)
    if ours and "segments" in record:
        _require_without(limits, f"{path} is of a task, which is judged by the limits that it was made for")
        task = validate(TaskRecord, record, f"plan {folder / JSON_NAME}")
        return _check_task(task, folder, checker or open_world(world), step)
    if os.path.isdir(path) and not os.path.isfile(path / TRAJECTORY_NAME) and record:
        path = path / JSON_NAME
    read = cache(lambda robot: read_motion(path, robot, record if path.name == JSON_NAME and record else None))
    message = None if given.robot is not None and given.robot != config.get("robot") else config.get("request")
    checker = checker or open_world(world, message, lambda checker: _first(read(checker.robot)))
    motion = read(checker.robot)
    if isinstance(motion, Points):
        if limits is None and motion.limits is not None:
            require_of_robot(checker.robot, motion.limits)
        return check_trajectory(checker, motion, _limits(limits, checker.robot), step, progress)
    _require_without(limits, f"{path} holds a path without times, and limits are of motions")
    return check_path(checker, motion, step, progress)


def read_record(folder: Path) -> dict[str, Any]:
    """The content of the plan.json in a folder; empty where there is none, or it is not a plan's."""
    place = folder / JSON_NAME
    if not os.path.isfile(place):
        return {}
    record = parse(read_text(place, "plan"), f"plan {place}")
    return record if isinstance(record, dict) and isinstance(record.get("config", {}), dict) else {}


def with_config(given: PartialWorld, config: Mapping[str, Any]) -> WorldRequest:
    """The robot and scene that are ``given``, and what they leave out by the ``config`` of a plan.json.

    Of the config of another robot the scene, the margin and the constraints are taken.
    """
    options = {name: value for name, value in config.items() if value is not None}
    if given.robot is not None and given.robot != config.get("robot"):
        options = {name: options[name] for name in ("scene", "margin", "keep") if name in options}
    if given.group is not None or given.joints is not None:
        options = {name: value for name, value in options.items() if name not in ("group", "joints")}
    own = {each.name: getattr(given, each.name) for each in fields(given)}  # type: ignore[arg-type]
    own = {name: value for name, value in own.items() if value not in (None, ())}
    return replace(world_in(options, "next to it"), **own)


def _check_task(record: TaskRecord, folder: Path, checker: CollisionChecker, step: float) -> Report:
    timed = any(segment.trajectory for segment in record.segments) or os.path.isfile(folder / TRAJECTORY_NAME)
    whole = load_trajectory(folder / TRAJECTORY_NAME) if timed else None
    if whole is not None and whole.limits is not None and whole.joints == checker.robot.joints:
        require_of_robot(checker.robot, whole.limits)
    return check_task(record, checker, whole, step)


def _first(motion: Floats | Points) -> Floats:
    """Where a motion begins (dof,)."""
    return motion.columns[0][0] if isinstance(motion, Points) else motion[0]


def _limits(limits: MotionLimits | LimitsRequest | None, robot: Robot) -> MotionLimits | None:
    return MotionLimits.of(robot, limits) if isinstance(limits, LimitsRequest) else limits


def _require_without(limits: MotionLimits | LimitsRequest | None, why: str) -> None:
    """Raise :class:`OptionError` for limits of a motion that has none, with the reason ``why``."""
    if limits is not None:
        raise OptionError(f"{why}: leave --limits, --velocity-scale, --acceleration, --jerk and their like out.")
