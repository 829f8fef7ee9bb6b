"""Configurations of the arm for poses of the tool, and for straight lines of it."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats
from planner.kinematics.inverse import Tolerance, distinct_rows, solve_within
from planner.kinematics.manipulability import manipulability
from planner.robot.robot import Robot
from planner.tasks.file import Line

STEP = 0.05  # m of a line between two solutions; between them the tool leaves the line by about STEP² / 8 / reach
RELEASE = 5e-3  # m next to a grasp or a placement, on which an object may touch what it stands on
_JUMP = 0.5  # rad (m): neighbouring solutions farther apart are not of one line
_APART = 1e-2  # rad: solutions nearer to each other are one


def solutions(robot: Robot, pose: Floats, seeds: Floats, most: int, tolerance: Tolerance) -> Floats:
    """At most ``most`` distinct configurations (k, dof) that bring the tool to ``pose``, best manipulability first.

    From each of the ``seeds`` (n, dof), by damped least squares as :func:`planner.kinematics.inverse.solve_within`,
    within a ``tolerance`` (m, rad).
    """
    found = _ends(robot, pose, seeds, tolerance)
    best = np.argsort(-manipulability(robot, found), kind="stable") if len(found) else slice(0)
    return distinct_rows(robot, found[best], _APART, most)


def along(robot: Robot, q: Floats, poses: Floats, tolerance: Tolerance) -> Floats | None:
    """Configurations (k + 1, dof) from ``q`` on with the tool at ``poses`` (k, 4, 4); None where that cannot be.

    A line ends where a solution is missing, or lies a jump away from the one before it.
    """
    path = [q]
    for pose in poses:
        found = _ends(robot, pose, path[-1][None], tolerance)
        if not len(found) or np.abs(robot.difference(path[-1], found[0])).max() > _JUMP:
            return None
        path.append(path[-1] + robot.difference(path[-1], found[0]))
    return np.array(path)


def _ends(robot: Robot, pose: Floats, seeds: Floats, tolerance: Tolerance) -> Floats:
    ends, _, _, solved = solve_within(robot, np.broadcast_to(pose, (len(seeds), 4, 4)), seeds, tolerance)
    return ends[solved]


def line_poses(rest: Floats, line: Line, forward: bool, margin: float) -> Floats:
    """Poses (k, 4, 4) of the tool from ``rest`` (4, 4) on: back along an approach, or ``forward`` along a retreat.

    The first is ``RELEASE`` beyond the ``margin`` (m) away from the rest, or at the line's end where that is nearer,
    the others up to ``STEP`` apart. One pose at least: without a line it is the rest itself.
    """
    axis = np.array(line.axis) if line.frame == "world" else rest[:3, :3] @ np.array(line.axis)
    first = min(RELEASE + margin, line.distance)
    rest_of = line.distance - first
    count = int(np.ceil(rest_of / STEP - 1e-9))
    distances = np.append(first, first + rest_of * (np.arange(count) + 1) / max(count, 1))
    found = np.tile(rest, (count + 1, 1, 1))
    found[:, :3, 3] += np.outer(distances if forward else -distances, axis)
    return found
