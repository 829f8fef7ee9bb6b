"""``planner export``."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, TypeAlias

import tyro

from planner.cli.common import Flag
from planner.cli.terminal import complain, say

Format: TypeAlias = Literal["ros-yaml", "ros-json", "moveit", "csv", "npz", "mcap"]


def export(
    trajectory: tyro.conf.Positional[Path],
    format: Format = "ros-yaml",
    rate: float | None = None,
    skip_first_point: Flag = False,
    out: Path | None = None,
    debug: Flag = False,
) -> int:
    """Write a trajectory as a controller or another program takes it.

    TRAJECTORY is a trajectory.json, or the folder that 'planner plan' wrote it into. ros-yaml and ros-json are a
    trajectory_msgs/JointTrajectory, moveit is a moveit_msgs/RobotTrajectory, csv and npz hold t, q, qd and qdd, mcap is
    a bag of ROS 2 with one JointTrajectory (it needs the Python package mcap). The points are the knots of the
    polynomials that were proven, with positions, velocities and accelerations: between them a ROS 2 joint trajectory
    controller runs these same polynomials. Examples:

    planner export out

    planner export out --format csv --rate 1000 --out motion.csv

    planner export out --format ros-json --skip-first-point

    For ros-json the command line of a FollowJointTrajectory goal is printed too.

    Exit code 0: written; 2: a wrong option; 3: an unusable file.

    Args:
        format: What to write.
        rate: Points at least that often (Hz); the knots stay, and the points between them lie on the same curve.
        skip_first_point: Leave out the point at time 0, where the robot stands already.
        out: File to write; beside the trajectory where left out.
        debug: Show tracebacks of errors.
    """
    from planner.base.files import is_folder, require_writable_file, write_whole
    from planner.motion import export as formats
    from planner.motion.file import load_trajectory

    if rate is not None:
        formats.require_rate(rate)
    folder = trajectory if is_folder(trajectory) else trajectory.parent
    place = out or folder / f"trajectory-{format}.{formats.SUFFIX[format]}"
    found = load_trajectory(trajectory)
    content = formats.export(found, format, rate, skip_first_point)
    require_writable_file(place)
    write_whole(place, content)
    if not found.proven:
        complain("the trajectory is not proven as a whole: see 'proof' in its file, or 'planner check'.")
    if format == "ros-json":
        say(_goal(place, len(content)))
    say(f"{found.duration:.3f} s. Written: {place}")
    return 0


def _goal(place: Path, size: int) -> str:
    from planner.motion.export import LONGEST_ARGUMENT, goal_command

    command = goal_command(place)
    if size < LONGEST_ARGUMENT:
        return command
    return f"{command}\n(too long for one argument on Linux: send the file from a program, or without --rate)"
