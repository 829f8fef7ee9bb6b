"""``planner check``."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from planner.base.errors import OptionError
from planner.base.files import json_text
from planner.cli.common import Debug, Flag
from planner.cli.terminal import complain, facts, say, show, watching
from planner.problem.request import LimitsRequest, WorldRequest

if TYPE_CHECKING:
    from planner.base.arrays import Floats
    from planner.collision.checker import CollisionChecker
    from planner.robot.robot import Robot
    from planner.tasks.judge import TaskRecord
    from planner.trajectory.points import Points

EXIT_NOT_USABLE = 4


def check(
    path: tyro.conf.Positional[Path],
    request: WorldRequest = WorldRequest(),  # noqa: B008 (frozen)
    motion: LimitsRequest = LimitsRequest(),  # noqa: B008
    step: float = 0.001,
    json: Flag = False,
    debug: Debug = False,
) -> int:
    """Check a joint path or trajectory from any source again: limits, contacts, clearance, proofs, manipulability.

    PATH is a plan.json, or its folder if it has no times, a JSON list of rows, {"joints": [...], "path": [...]}, a
    trajectory message with joint_names and points as JSON, or a CSV; columns with names are put in order, those of
    joints that are not planned are left out with a note, and what nobody knows is refused. Values are rad (m where a
    joint slides), the motion between two rows is straight in joint space; a joint without limits turns the shorter way.

    Rows with times are a trajectory: a trajectory.json or its folder, a JointTrajectory, RobotTrajectory or
    FollowJointTrajectory goal as JSON or YAML, a CSV with a column t, or a bag of
    ROS 2 in MCAP. Then what a ROS 2 joint trajectory controller makes of it is checked (lines, with velocities cubics,
    with accelerations quintics) against the limits on velocity, acceleration and jerk too: those of the options, else
    of the trajectory.json, else the robot's own. Where a velocity or an acceleration jumps at a point, the acceleration
    or the jerk is infinite: beyond every limit that somebody gives, and not judged, which is said, where it is assumed
    for want of any. Examples:

    A task's plan.json, or its folder, is judged segment by segment, with what is held and what stands where by then;
    so are the commands of its gripper, and whether each object that it lets go of stands on something.

    planner check out/plan.json

    planner check trajectory.csv --robot panda --scene shelf --margin 0.01 --collision coal

    planner check moveit.yaml --robot panda --scene shelf --acceleration-scale 0.5

    Limits are named first. A path that looks like degrees is not checked further.

    Exit code 0: free and within limits; 4: not; 2: a wrong option; 3: an unusable robot, scene or file.

    Args:
        path: The file with the path.
        step: Metres of motion between two looks; proofs of whole segments come on top.
        json: Print the report as JSON on standard output, and nothing else there.
    """
    from planner.trajectory.path_check import check_path, require_step, worst_excess

    require_step(step)
    from planner.planning.result import JSON_NAME
    from planner.query.query import open_world
    from planner.query.resolve import looks_like_degrees
    from planner.tasks.judge import task_record
    from planner.trajectory.file import TRAJECTORY_NAME
    from planner.trajectory.path_file import read_joint_path
    from planner.trajectory.path_report import excess_text, report_record, report_rows, verdict_sentence
    from planner.trajectory.points import read_points

    without_times = (
        os.path.isdir(path) and not os.path.isfile(path / TRAJECTORY_NAME) and os.path.isfile(path / JSON_NAME)
    )
    path = path / JSON_NAME if without_times else path
    task = task_record(path)
    checker = open_world(request, start=None if task else lambda checker: _first(path, checker.robot))
    if task is not None:
        _require_unasked(motion, f"{path} is of a task, which is judged by the limits that it was made for")
        return _check_task(path, task, checker, step, json)
    robot, scene = checker.robot, checker.world.scene
    points = read_points(path, robot)
    if points is not None:
        return _check_trajectory(path, checker, points, motion, step, json)
    _require_unasked(motion, f"{path} holds a path without times, and limits are of motions")
    waypoints = read_joint_path(path, robot)
    if json:
        report = check_path(checker, waypoints, step)
        say(json_text(report_record(report)))
    else:
        excess = worst_excess(robot, waypoints)
        if excess is not None and not looks_like_degrees(robot, waypoints):
            complain(f"{excess_text(robot, excess)}; the rest of the path is checked all the same.")
        with watching() as progress:
            report = check_path(checker, waypoints, step, progress)
        show(facts(f"{path}: {robot.name} in {scene.name}", report_rows(report)))
        say(verdict_sentence(report))
    return 0 if report.ok else EXIT_NOT_USABLE


def _require_unasked(motion: LimitsRequest, why: str) -> None:
    """Raise :class:`OptionError` for options that say nothing of what a file holds, with ``why`` they do not."""
    if motion != LimitsRequest():
        raise OptionError(f"{why}: leave --limits, --velocity-scale, --acceleration, --jerk and their like out.")


def _first(path: Path, robot: Robot) -> Floats:
    """Where the path or trajectory in a file begins (dof,)."""
    from planner.trajectory.path_file import read_joint_path
    from planner.trajectory.points import read_points

    points = read_points(path, robot)
    return read_joint_path(path, robot)[0] if points is None else points.columns[0][0]


def _check_task(path: Path, task: TaskRecord, checker: CollisionChecker, step: float, json: bool) -> int:
    from planner.tasks.judge import judged, summary
    from planner.trajectory.file import TRAJECTORY_NAME, load_trajectory
    from planner.trajectory.limits import require_of_robot

    folder = path if path.is_dir() else path.parent
    timed = any(segment.trajectory for segment in task.segments) or os.path.isfile(folder / TRAJECTORY_NAME)
    whole = load_trajectory(folder / TRAJECTORY_NAME) if timed else None
    if whole is not None and whole.limits is not None and whole.joints == checker.robot.joints:
        require_of_robot(checker.robot, whole.limits)
    found = summary(list(judged(task, checker, whole, step)))
    if json:
        say(json_text(found))
    else:
        rows = [
            (
                f"step {each['step']}, {each['doing']}",
                f"{each['part']}: {' '.join(each['findings']).rstrip('.') or 'free'}"
                + "".join(f"; '{a}' may touch '{b}'" for a, b in each["may_touch"]),
            )
            for each in found["segments"]
        ]
        show(facts(f"{path}: {checker.robot.name} in {checker.world.scene.name}", rows))
        bad = sum(not each["ok"] for each in found["segments"])
        wrong = f"{bad} of {len(rows)} segments are not free and within limits, or end wrongly."
        say(wrong if bad else "All segments are free.")
    return 0 if found["ok"] else EXIT_NOT_USABLE


def _check_trajectory(
    path: Path,
    checker: CollisionChecker,
    points: Points,
    motion: LimitsRequest,
    step: float,
    json: bool,
) -> int:
    from planner.trajectory.check import check_trajectory
    from planner.trajectory.limits import MotionLimits, require_of_robot
    from planner.trajectory.report import report_record, report_rows, verdict_sentence

    own = points.limits if motion == LimitsRequest() else None
    if own is not None:
        require_of_robot(checker.robot, own)
    limits = own or MotionLimits.of(checker.robot, motion)
    if json:
        report = check_trajectory(checker, points, limits, step)
        say(json_text(report_record(report)))
    else:
        with watching() as progress:
            report = check_trajectory(checker, points, limits, step, progress)
        show(facts(f"{path}: {checker.robot.name} in {checker.world.scene.name}", report_rows(report)))
        say(verdict_sentence(report))
    return 0 if report.ok else EXIT_NOT_USABLE
