"""``planner check``."""

from __future__ import annotations

from pathlib import Path

import tyro

from planner.base.files import json_text
from planner.cli.common import Debug, Flag
from planner.cli.terminal import facts, say, show, watching
from planner.problem.request import LimitsRequest, PartialWorld

EXIT_NOT_USABLE = 4


def check(
    path: tyro.conf.Positional[Path],
    world: PartialWorld = PartialWorld(),  # noqa: B008 (frozen)
    motion: LimitsRequest = LimitsRequest(),  # noqa: B008
    step: float = 0.001,
    json: Flag = False,
    debug: Debug = False,
) -> int:
    """Check a joint path, a trajectory or a task from any source again: limits, contacts, clearance, proofs.

    PATH is a file, or the folder of a plan or a task: plan.json, trajectory.json, a JSON list of rows,
    {"joints": [...], "path": [...]}, a JointTrajectory, RobotTrajectory or FollowJointTrajectory goal as JSON or YAML,
    a CSV, or a bag of ROS 2 in MCAP. Robot and scene are those of the plan.json next to it, where they are not given.
    Columns with names are put in order, those of joints that are not planned are left out with a note, and an unknown
    column is refused. Values are rad (m where a joint slides), the motion between two rows is straight in joint space.

    Rows with times are checked as a ROS 2 joint trajectory controller runs them (lines, with velocities cubics, with
    accelerations quintics), also against the limits on velocity, acceleration and jerk: those of the options, else of
    the trajectory.json, else the robot's own. A jump of the velocity is an infinite acceleration, beyond every limit
    that is given; a limit that is merely assumed does not judge it. A task is checked segment by segment, with what is
    held and what stands where by its events, the commands of its gripper, and the support of each object that it
    releases. Examples:

    planner check out

    planner check trajectory.csv --robot panda --scene shelf --margin 0.01 --collision coal

    planner check moveit.yaml --robot panda --scene shelf --acceleration-scale 0.5

    Exit code 0: free and within limits; 4: not; 2: a wrong option; 3: an unusable robot, scene or file.

    Args:
        path: The file with the path, or the folder of a plan.
        step: Metres of motion between two samples; proofs of whole segments come on top.
        json: Print the report as JSON on standard output, and nothing else there.
    """
    from planner.trajectory.check import require_step

    require_step(step)
    from planner.tasks.check import check_file

    limits = None if motion == LimitsRequest() else motion
    if json:
        report = check_file(path, world, limits, step)
        say(json_text(report.to_dict()))
    else:
        with watching() as progress:
            report = check_file(path, world, limits, step, progress)
        against = report.checker.world
        show(facts(f"{path}: {against.robot.name} in {against.scene.name}", report.rows()))
        say(report.sentence)
    return 0 if report.ok else EXIT_NOT_USABLE
