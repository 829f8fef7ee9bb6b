"""``planner export``."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

import tyro

from planner.base.errors import FileError, PlannerError, choices
from planner.cli.common import Debug, Flag
from planner.cli.terminal import complain, say

if TYPE_CHECKING:
    from planner.collision.checker import CollisionChecker
    from planner.trajectory.trajectory import Trajectory

Format: TypeAlias = Literal["ros-json", "csv", "mcap"]


def export(
    trajectory: tyro.conf.Positional[Path],
    format: Format = "ros-json",
    rate: float | None = None,
    skip_first_point: Flag = False,
    out: Path | None = None,
    debug: Debug = False,
) -> int:
    """Write a trajectory as a controller or another program takes it.

    TRAJECTORY is a trajectory.json, or the folder that 'planner plan' wrote it into. ros-json is a
    trajectory_msgs/JointTrajectory, which YAML reads too, csv holds t, q, qd and qdd, mcap is a bag of ROS 2 with one
    JointTrajectory (it needs the Python package mcap). The points are the knots of the
    polynomials that were proven, with positions, velocities and accelerations: between them a ROS 2 joint trajectory
    controller runs these same polynomials. Examples:

    planner export out

    planner export out --format csv --rate 1000 --out motion.csv

    planner export out --skip-first-point

    The events of a task (attach, detach, gripper) stand in trajectory.json only; a message lists them.

    With --rate the points are rows on an exact grid, for a controller that takes one a cycle. The motion is averaged
    over two periods for that, so that it keeps the same limits, and its end is held to a row: what it takes longer and
    how far it leaves the planned curve is told. It is proven anew in the world of the plan.json beside it.

    Beside ros-json stands send_trajectory.py, which sends the file as a FollowJointTrajectory goal.

    Exit code 0: written; 2: a wrong option; 3: an unusable file, or a grid too coarse for its motion to be proven.

    Args:
        format: What to write.
        rate: Rows at every k/rate s (Hz), to the nanosecond, in place of the knots.
        skip_first_point: Leave out the point at time 0, where the robot stands already.
        out: File to write; beside the trajectory where left out.
    """
    from planner.base.files import require_writable_file, write_whole
    from planner.trajectory import export as formats
    from planner.trajectory.file import load_trajectory
    from planner.trajectory.grid import require_rate

    if rate is not None:
        require_rate(rate)
    folder = trajectory if os.path.isdir(trajectory) else trajectory.parent
    place = out or folder / f"trajectory-{format}.{formats.SUFFIX[format]}"
    made, said = load_trajectory(trajectory), ""
    events = [f"{event['kind']} '{event['object']}' at {event['t']:.3f} s" for event in made.events]
    if rate is not None:
        made, said = _on_grid(made, rate, folder)
    content = formats.export(made, format, skip_first_point)
    require_writable_file(place)
    write_whole(place, content)
    if events:
        complain(f"{format} has no place for the events of a task, which trajectory.json holds: {choices(events)}.")
    if len(made.columns) > 1 and made.columns[1][-1].any():
        complain(
            "the motion does not end at rest, which a ROS 2 joint trajectory controller refuses unless it is told."
        )
    if not said and not made.proven:
        complain("the trajectory is not proven as a whole: see 'proof' in its file, or 'planner check'.")
    if format == "ros-json":
        sender = place.with_name(formats.SENDER_NAME)
        write_whole(sender, formats.SENDER.encode())
        say(f"To run it, with ROS 2: python3 {shlex.quote(str(sender))} {shlex.quote(str(place))}")
    if said:
        say(said)
    say(f"{made.duration:.3f} s. Written: {place}")
    return 0


def _on_grid(found: Trajectory, rate: float, folder: Path) -> tuple[Trajectory, str]:
    """The trajectory on a grid, proven in the world of the plan in ``folder``, and what is to be said of it.

    Raises :class:`FileError` where it is not proven any more.
    """
    from planner.trajectory.grid import on_grid

    try:
        checker, unknown = _world(folder, found), ""
    except PlannerError as error:
        checker, unknown = None, str(error)
    made = on_grid(found, rate, checker)
    if checker is not None and found.proven and not made.proven:
        left = made.proof["pieces"] - made.proof["pieces_free"]
        raise FileError(
            f"on a grid of {rate:g} Hz the motion is not proven as a whole any more ({left} of {made.proof['pieces']} "
            "pieces between rows are not proven free): give a higher rate."
        )
    told = _told(found, made, rate)
    if made.proven:
        return made, f"{told}; proven free and within limits."
    why = "nor was the trajectory itself" if checker else f"its world is not known ({unknown.rstrip('.')})"
    complain(f"the motion on the grid is not proven: {why}; try 'planner check'.")
    return made, f"{told}; NOT proven."


def _told(found: Trajectory, made: Trajectory, rate: float) -> str:
    """What became of a trajectory on a grid, as the beginning of a sentence."""
    from planner.trajectory.grid import off_the_curve, period_of

    period = period_of(rate)
    whole = period.denominator == 1
    apart = f"{float(period) / 1e6:.9g} ms exactly" if whole else f"1/{rate:g} s, rounded to the nanosecond"
    longer = f"{1e3 * (made.duration - found.duration):.3g} ms longer than by its knots"
    off = f"{off_the_curve(made, found):.1e} rad (m) off that curve at most"
    return f"On a grid: {len(made.times)} rows, one every {apart}; the end held to a row, {longer}; {off}"


def _world(folder: Path, found: Trajectory) -> CollisionChecker:
    """The world of the plan in ``folder``; :class:`PlannerError` where there is none, or it is another robot's."""
    from planner.cli.common import world_of_plan
    from planner.trajectory.limits import require_of_robot

    checker = world_of_plan(folder)
    if checker.robot.joints != found.joints:
        raise FileError(f"{folder / 'plan.json'} is of other joints than the trajectory: plan again.")
    if found.limits is not None:
        require_of_robot(checker.robot, found.limits)
    return checker
