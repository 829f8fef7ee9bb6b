"""Trajectories of a composite robot and of its parts, on one clock."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import FileError, choices
from planner.robot.robot import Robot
from planner.trajectory.limits import KINDS
from planner.trajectory.trajectory import Trajectory

_STILL = 1e-9  # rad (m): of a joint that rests


def split_trajectory(motion: Trajectory, robot: Robot) -> dict[str, Trajectory]:
    """Return the motion of each part of a composite ``robot`` by name, at the same knots.

    The joints keep their prefix. The motions are columns of ``motion``, whose proof holds for all of them together.
    """
    parts, first = dict[str, Trajectory](), 0
    for part in robot.parts.values():
        columns = slice(first, first + part.dof)
        joints, first = motion.joints[columns], first + part.dof
        limits = motion.limits
        if limits is not None:
            rows = {kind: frozen(getattr(limits, kind)[columns]) for kind in KINDS}
            limits = replace(limits, joints=joints, **rows)
        rates = tuple(frozen(column[:, columns]) for column in motion.columns)
        parts[part.name] = replace(motion, joints=joints, columns=rates, limits=limits)
    return parts


def busy_seconds(motion: Trajectory) -> float:
    """Return the time (s) from the start of a motion until the last joint rests."""
    moves = np.flatnonzero(np.abs(motion.columns[0] - motion.columns[0][-1]).max(axis=1) > _STILL)
    return float(motion.times[moves[-1] + 1] - motion.times[0]) if len(moves) else 0.0


def merge_trajectories(motions: Mapping[str, Trajectory], robot: Robot, rest: Mapping[str, Floats]) -> Trajectory:
    """Return the motion of a composite ``robot`` from those of its parts by name, on one clock.

    A part without a motion rests at its configuration of ``rest``, others before and after their own. Pieces are cut
    at all knots.
    Raises :class:`FileError` for motions with different interpolation, or of other joints.
    """
    kinds = dict.fromkeys(motion.interpolation for motion in motions.values())
    if len(kinds) > 1:
        raise FileError(
            f"trajectories must have one interpolation, got {choices(kinds)}: give velocities and accelerations in all."
        )
    orders = min(len(motion.columns) for motion in motions.values())
    clock = np.unique(np.concatenate([motion.nanoseconds for motion in motions.values()]))
    columns = [list[Floats]() for _ in range(orders)]
    for part in robot.parts.values():
        motion = motions.get(part.name)
        for order, rows in enumerate(columns):
            if motion is None:
                rows.append(np.tile(rest[part.name] if order == 0 else 0.0 * part.home, (len(clock), 1)))
                continue
            own = motion.at_nanoseconds(clock, order)
            at_knot = np.isin(clock, motion.nanoseconds)
            own[at_knot] = motion.columns[order][np.isin(motion.nanoseconds, clock)]
            rests = (clock < motion.nanoseconds[0]) | (clock > motion.nanoseconds[-1])
            own[rests] = own[rests] if order == 0 else 0.0
            rows.append(own)
    return Trajectory(robot.joints, clock, tuple(np.concatenate(rows, axis=1) for rows in columns))
