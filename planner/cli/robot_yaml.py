"""``planner robot-yaml``."""

from pathlib import Path
from typing import Annotated

import tyro
from typing_extensions import Doc

from planner.base.errors import FileError
from planner.base.files import require_writable_file
from planner.cli.common import Debug
from planner.cli.terminal import say
from planner.problem.request import WorldRequest


def robot_yaml(
    robot: Annotated[tyro.conf.Positional[str], Doc("A URDF, xacro, MJCF or robot.yaml, or the name of a robot.")],
    srdf: Annotated[Path | None, Doc("An SRDF with disabled pairs, groups and named states.")] = None,
    tool: Annotated[str | None, Doc("Frame of targets and manipulability; left out, the tip of the group.")] = None,
    group: Annotated[str | None, Doc("Planning group of the SRDF: its joints are planned, others held.")] = None,
    joints: Annotated[str | None, Doc("Joints to plan, with commas between; others are held.")] = None,
    out: Annotated[Path, Doc("File to write; an existing file is not overwritten.")] = Path("robot.yaml"),
    debug: Debug = False,
) -> int:
    """Write a robot.yaml for a URDF.

    The file lists the link pairs that need no collision check: neighbours, and pairs that touch in nearly every
    configuration. Then home, random configurations and targets of the robot are tested. Exit codes: 0 written, 2 wrong
    option, 3 unusable robot or file, or --out exists.
    """
    choice = WorldRequest(group=group, joints=joints)  # type: ignore[arg-type]
    if out.exists():
        raise FileError(f"{out} exists and is not overwritten: choose another --out, or remove it.")
    require_writable_file(out)
    from planner.query.robot_yaml import write_robot_yaml
    from planner.robot.files.robot_files import JointChoice

    for sentence in write_robot_yaml(robot, srdf, tool, JointChoice(group, choice.joints), out):
        say(sentence)
    return 0
