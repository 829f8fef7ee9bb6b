"""``planner export``."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import tyro
from typing_extensions import Doc

from planner.base.errors import FileError, PlannerError, choices
from planner.base.files import require_writable_file, write_whole
from planner.cli.common import Debug, world_of_plan
from planner.cli.terminal import complain, say

if TYPE_CHECKING:
    from planner.trajectory.trajectory import Trajectory

Format: TypeAlias = Literal["ros-json", "csv", "mcap"]


def export(
    trajectory: Annotated[tyro.conf.Positional[Path], Doc("A trajectory.json, or the folder of a result.")],
    format: Annotated[Format, Doc("Format of the file; ros-json is a JointTrajectory.")] = "ros-json",
    rate: Annotated[float | None, Doc("Rows per second, at every k/rate s, in place of the knots.")] = None,
    beta: Annotated[float | None, Doc("For a sweep: export the motion that is optimal at this beta.")] = None,
    skip_first_point: Annotated[bool, Doc("Leave out the point at time 0, where the robot already stands.")] = False,
    out: Annotated[Path | None, Doc("File to write; left out, next to the trajectory.")] = None,
    debug: Debug = False,
) -> int:
    """Write a motion as ROS JSON, CSV or MCAP.

    The points are the knots of the proven polynomials, which a ROS 2 joint trajectory controller interpolates in the
    same way. With --rate they are rows on an exact grid, and the motion is proven again. Next to ros-json stands
    send_trajectory.py, which sends the file to a controller. Exit codes: 0 written, 2 wrong option, 3 unusable file,
    or a grid too coarse for a proof.
    """
    from planner.tradeoff.record import SWEEP_NAME
    from planner.trajectory import export as formats
    from planner.trajectory.file import TRAJECTORY_NAME
    from planner.trajectory.trajectory import Trajectory

    if rate is not None:
        formats.require_rate(rate)
    folder, stem, notes = trajectory if os.path.isdir(trajectory) else trajectory.parent, "trajectory", list[str]()
    if beta is not None:
        trajectory, notes = _motion_at(folder, beta)
        stem = trajectory.stem
    elif os.path.isfile(trajectory) and trajectory.suffix == ".json":
        stem = trajectory.stem  # of one robot of a cell, or of a sweep
    elif os.path.isfile(trajectory / SWEEP_NAME) and not os.path.isfile(trajectory / TRAJECTORY_NAME):
        raise FileError(f"{trajectory} must be a plan or have a beta, got a sweep: give --beta.")
    place = out or folder / f"{stem}-{format}.{formats.SUFFIX[format]}"
    motion = Trajectory.load(trajectory)
    if rate is None and not motion.proven:
        notes.append("the trajectory is not proven as a whole: see 'proof' in its file, or 'planner check'.")
    if events := [f"{event['kind']} '{event['object']}' at {event['t']:.3f} s" for event in motion.events]:
        notes.append(f"{format} has no place for the events of a task, which trajectory.json holds: {choices(events)}.")
    if len(motion.columns) > 1 and motion.columns[1][-1].any():
        notes.append("the motion does not end at rest, which a ROS 2 joint trajectory controller refuses by default.")
    result = ""
    if rate is not None:
        motion, result = _on_grid(motion, rate, folder)
    content = formats.export(motion, format, skip_first_point)
    require_writable_file(place)
    write_whole(place, content)
    for note in notes:
        complain(note)
    if format == "ros-json":
        sender = place.with_name(formats.SENDER_NAME)
        write_whole(sender, formats.SENDER.encode())
        say(f"To run it, with ROS 2: python3 {shlex.quote(str(sender))} {shlex.quote(str(place))}")
    say(f"{result}{motion.duration:.3f} s. Written: {place}")
    return 0


def _motion_at(folder: Path, beta: float) -> tuple[Path, list[str]]:
    """Return the file of the motion at ``beta`` in the folder of a sweep, and notes on the choice."""
    from planner.tradeoff.record import interval_at, range_text, read_sweep

    item, note = interval_at(read_sweep(folder).intervals, beta)
    if item is None:
        raise FileError(f"the sweep in {folder} was interrupted before beta {beta:g}: sweep again.")
    if item.trajectory is None:
        raise FileError(f"the sweep in {folder} has no motions: run 'planner sweep' with times.")
    text = f"the path is optimal for beta from {range_text(item.beta_min, item.beta_max)}, of the paths in its roadmap."
    return folder / item.trajectory, [f"{note}." if note else text]


def _on_grid(given: Trajectory, rate: float, folder: Path) -> tuple[Trajectory, str]:
    """Return the trajectory on a grid, proven in the world of ``folder``, and a sentence on the changes."""
    from planner.trajectory.export import deviation_from_curve, period_of, resample
    from planner.trajectory.limits import require_within_robot
    from planner.trajectory.proof import require_joints

    checker, unknown = None, ""
    try:
        checker = world_of_plan(folder)
        require_joints(given.joints, checker)
        if given.limits is not None:
            require_within_robot(checker.robot, given.limits)
    except PlannerError as error:
        checker = None
        unknown = f"its world is not known ({str(error).rstrip('.')})"
    motion, period = resample(given, rate, checker), period_of(rate)
    if checker is not None and given.proven and not motion.proven:
        left = motion.proof["pieces"] - motion.proof["pieces_free"]
        raise FileError(
            f"on a grid of {rate:g} Hz the motion is not proven as a whole any more ({left} of "
            f"{motion.proof['pieces']} pieces between rows are not proven free): give a higher rate."
        )
    if not motion.proven:
        complain(f"the motion on the grid is not proven: {unknown or 'nor was the trajectory'}; try 'planner check'.")
    exact = f"{float(period) / 1e6:.9g} ms exactly" if period.denominator == 1 else f"1/{rate:g} s, to the nanosecond"
    longer = f"{1e3 * (motion.duration - given.duration):.3g} ms longer than by its knots"
    off = f"{deviation_from_curve(motion, given):.1e} rad (m) off that curve at most"
    rows = f"On a grid: {len(motion.times)} rows, one every {exact}; the end held to a row, {longer}; {off}"
    return motion, f"{rows}; {'proven free and within limits' if motion.proven else 'NOT proven'}.\n"
