"""``planner robot-yaml``."""

from pathlib import Path

import tyro

from planner.base.errors import FileError
from planner.base.files import require_writable_file
from planner.cli.common import Debug
from planner.cli.terminal import say
from planner.problem.request import WorldRequest


def robot_yaml(
    robot: tyro.conf.Positional[str],
    srdf: Path | None = None,
    tool: str | None = None,
    group: str | None = None,
    joints: str | None = None,
    out: Path = Path("robot.yaml"),
    debug: Debug = False,
) -> int:
    """Write a robot.yaml for a URDF, with the link pairs that need no collision check.

    These are pairs of links that one joint joins, or that touch in nearly every random configuration. Then the robot is
    tried: its home, random configurations and targets; pairs of links that stand in the way are named. Where no file
    says where home is, and links touch or the arm is singular with all joints at zero, another one is chosen. Example:

    planner robot-yaml robots/examples/arm.urdf --tool tip --out mine/robot.yaml

    Exit code 0: written; 2: a wrong option; 3: an unusable robot or file, or --out is there already.

    Args:
        robot: The path of a URDF, xacro, MJCF or robot.yaml, or the name of a robot.
        srdf: An SRDF: its disabled pairs hold, its groups and named states are known.
        tool: Frame that targets and manipulability speak of; the tip of --group, or a likely frame, where left out.
        group: Planning group of the SRDF: its joints are planned, the others held.
        joints: Joints to plan, with commas between, the others held; those between base and tool where left out.
        out: The file to write; an existing file is not overwritten.
    """
    choice = WorldRequest(group=group, joints=joints)  # type: ignore[arg-type]
    if out.exists():
        raise FileError(f"{out} is there already and is not overwritten: choose another --out, or remove it.")
    require_writable_file(out)
    from planner.query.robot_yaml import write_robot_yaml
    from planner.robot.files.robot_files import JointChoice

    for sentence in write_robot_yaml(robot, srdf, tool, JointChoice(group, choice.joints), out):
        say(sentence)
    return 0
