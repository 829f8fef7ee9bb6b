"""``planner check`` and ``planner verify``: what is there already, judged again."""

import os
from pathlib import Path

import tyro

from planner.base.files import json_text
from planner.cli.common import Debug, Flag, world_of_plan
from planner.cli.terminal import complain, facts, say, show, watching
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
    a CSV, or a bag of ROS 2 in MCAP. Robot and scene are those of the plan.json next to it where not given. Values are
    rad (m where a joint slides); the motion between two rows is straight in joint space, or with times that of a ROS 2
    joint trajectory controller (lines, cubics with velocities, quintics with accelerations), which is also judged by
    limits: those of the options, else of the trajectory.json, else the robot's own. A task is checked segment by
    segment, with what is held, the commands of its gripper and the support of each object. Examples:

    planner check out

    planner check trajectory.csv --robot panda --scene shelf --margin 0.01 --acceleration-scale 0.5

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


def verify(out: tyro.conf.Positional[Path] = Path("out"), debug: Debug = False) -> int:
    """Check the certificate of a plan, proof.npz: that its path and its motion touch nothing and keep their limits.

    OUT is the folder that 'planner plan --certificate' wrote into. Robot and scene have to be, to the last bit, those
    of the certificate; then each of its witnesses is checked by tools/verify_proof.py, which needs numpy and no
    planner: run that where you would rather not believe this package. Examples:

    planner plan --certificate && planner verify out

    python tools/verify_proof.py out --urdf robot.urdf

    Exit code 0: proven; 4: not, and why; 2: a wrong option; 3: an unusable robot, scene or file.

    Args:
        out: The folder with plan.json, roadmap.npz and proof.npz, or one of these files.
    """
    from planner.certificate import verify as verified
    from planner.certificate.certificate import require_certificate
    from planner.certificate.verify_proof import Refused

    out = out.parent if os.path.isfile(out) else out
    require_certificate(out)
    try:
        say(verified(out, world_of_plan(out).world))
    except Refused as why:
        complain(f"NOT proven: {why}")
        return EXIT_NOT_USABLE
    return 0
