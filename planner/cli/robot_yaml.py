"""``planner robot-yaml``."""

from __future__ import annotations

from pathlib import Path

import tyro

from planner.base.errors import FileError
from planner.base.files import make_folder, require_writable_file, write_whole
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

    These are pairs of links that one joint joins, or that touch in nearly every random configuration. Pairs that only
    never touched stay checked: a sample is no proof. Then the robot is tried: its home, random configurations and
    targets; pairs of links that stand in the way are named. Where no file says where home is, and links touch with all
    joints at zero, a home is chosen where none do. Examples:

    planner robot-yaml robots/examples/arm.urdf --tool tip --out mine/robot.yaml

    planner plan --robot mine/robot.yaml --scene empty --start home --goal q:0.5,0.8,-0.4

    Exit code 0: written; 2: a wrong option; 3: an unusable robot or file, or --out is there already.

    Args:
        robot: The path of a URDF, xacro, MJCF or robot.yaml, or the name of a robot.
        srdf: An SRDF: its disabled pairs hold, its groups and named states are known.
        tool: Frame that targets and manipulability speak of; the tip of --group, or the only tip, where left out.
        group: Planning group of the SRDF: its joints are planned, the others held.
        joints: Joints to plan, with commas between, the others held; those between base and tool where left out.
        out: The file to write; an existing file is not overwritten.
    """
    choice = WorldRequest(group=group, joints=joints)  # type: ignore[arg-type]

    if out.exists():
        raise FileError(f"{out} is there already and is not overwritten: choose another --out, or remove it.")
    require_writable_file(out)
    from planner.collision.coal import CoalChecker
    from planner.collision.self_pairs import generate_disabled_pairs
    from planner.collision.world import World
    from planner.query.robot_yaml import robot_yaml as text_of
    from planner.query.robot_yaml import self_test, with_free_home
    from planner.robot.files.robot_files import JointChoice, read_robot
    from planner.robot.model_checks import require_bodies
    from planner.robot.robot import assemble
    from planner.robot.scene import Scene

    files = read_robot(robot, srdf)
    arm = assemble(files, tool, JointChoice(group, choice.joints))
    require_bodies(arm)
    listed = arm.disabled_pairs or frozenset()
    never_apart = generate_disabled_pairs(arm, CoalChecker) - listed
    checker = CoalChecker(World.of(arm, Scene("none"), never_apart | listed))
    if not {*files.home} & {*arm.joints}:
        checker = with_free_home(checker)
    home = checker.robot.home
    make_folder(out.parent)
    write_whole(out, text_of(files, checker.robot, never_apart, out.parent).encode())
    if (home != arm.home).any():
        values = ",".join(f"{value:g}" for value in home.tolist())
        say(f"No file says where home is, and links touch with the joints at zero: home is q:{values} instead.")
    for sentence in self_test(checker):
        say(sentence)
    say(f"Written: {out}, with {len(never_apart)} pairs of links that need no check. Plan with --robot {out}")
    return 0
