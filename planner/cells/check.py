"""Trajectories of several robots checked together, on one clock."""

from collections.abc import Collection, Sequence
from pathlib import Path

from planner.base.errors import FileError, OptionError, PlannerError, choices
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import RECHECK
from planner.problem.request import LimitsRequest, PartialWorld, WorldRequest
from planner.query.query import make_checker_for
from planner.query.robots import load_cell
from planner.robot.cell import Cell
from planner.robot.composite import combine_robots
from planner.tasks.check import check
from planner.trajectory.parts import merge_trajectories
from planner.trajectory.recorded import read_motion
from planner.trajectory.report import Report
from planner.trajectory.trajectory import Trajectory


def check_files(
    files: Sequence[Path],
    world: PartialWorld,
    limits: LimitsRequest | None = None,
    step: float = RECHECK,
    progress: Progress = QUIET,
) -> Report:
    """Check the trajectories of robots of a cell together: each moves by its own file, and others rest.

    Joints have the prefix of their robot; without it, they have to fit one robot only. A robot without a file rests at
    its state ``start``, or at home. The contacts of the report name the links with prefix, and their time. Raises
    :class:`PlannerError` for files that fit no robot, or two for one.
    """
    if world.cell is None:
        raise OptionError("several files are motions of several robots: give their cell with --cell.")
    cell = load_cell(world.cell)
    checker = make_checker_for(
        WorldRequest(cell=cell, collision=world.collision, margin=world.margin or 0.0, constraint=world.constraint)
    )
    motions = dict[str, Trajectory]()
    for file in files:
        name, motion = _read(file, cell, motions)
        if name in motions:
            raise FileError(f"motion {file} must be of another robot, got a second one of '{name}': give one of each.")
        motions[name] = motion
    whole = merge_trajectories(motions, checker.robot, {name: cell.start_of(name) for name in cell.robots})
    return check(whole, checker=checker, limits=limits, step=step, progress=progress)


def _read(file: Path, cell: Cell, known: Collection[str]) -> tuple[str, Trajectory]:
    """Return the robot that a file moves, and its trajectory."""
    fits, error = dict[str, Trajectory](), None
    for prefixed in (True, False):
        for name, robot in cell.robots.items():
            part = combine_robots(name, {cell.prefixes[name]: robot}) if prefixed else robot
            try:
                motion = read_motion(file, part)
            except PlannerError as caught:
                error = error or caught
                continue
            if not isinstance(motion, Trajectory):
                raise FileError(f"motion {file} must have times, got a path: robots share one clock.")
            fits[name] = motion
        if fits:
            break
    else:
        assert error is not None
        raise error
    left = [name for name in fits if name not in known] or list(fits)
    if len(left) > 1:
        prefixes = choices(cell.prefixes[name] for name in left)
        raise FileError(f"motion {file} fits robots {choices(left)}: give its joints a prefix, {prefixes}.")
    return left[0], fits[left[0]]
