"""Configurations of the arm for poses of the tool, and for straight lines of it."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats
from planner.kinematics.forward import Chain, tool_joint
from planner.kinematics.inverse import ANGLE_TOLERANCE, POSITION_TOLERANCE
from planner.kinematics.manipulability import manipulability
from planner.models.robot import Robot
from planner.tasks.file import Line

STEP = 0.05  # m of a line between two solutions; between them the tool leaves the line by about STEP² / 8 / reach
RELEASE = 5e-3  # m next to a grasp or a placement, on which an object may touch what it stands on
_JUMP = 0.5  # rad (m): neighbouring solutions farther apart are not of one line
_APART = 1e-2  # rad: solutions nearer to each other are one
_ITERATIONS = 100


class Reach:
    """The inverse kinematics of one robot, for many poses of its tool."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self._chain = robot, Chain.of(robot).native
        self._joint, frame = tool_joint(robot)
        self._tool, self._limits = frame.homogeneous, (robot.lower, robot.upper, robot.continuous)

    def solutions(self, pose: Floats, seeds: Floats, most: int) -> Floats:
        """At most ``most`` distinct configurations (k, dof) that bring the tool to ``pose``, best manipulability first.

        From each of the ``seeds`` (n, dof), by damped least squares as :mod:`planner.kinematics.inverse` has it.
        """
        found = self._ends(pose, seeds)
        kept = np.zeros((0, self.robot.dof))
        for q in found[np.argsort(-manipulability(self.robot, found), kind="stable")] if len(found) else found:
            if (np.abs(self.robot.difference(q, kept)).max(axis=1, initial=0.0) > _APART).all():
                kept = np.vstack([kept, self.robot.normalise(q)])
            if len(kept) == most:
                break
        return kept

    def along(self, q: Floats, poses: list[Floats]) -> Floats | None:
        """Configurations (k + 1, dof) from ``q`` on that follow the tool through ``poses`` (k); None where they cannot.

        A line ends where a solution is missing, or lies a jump away from the one before it.
        """
        path = [q]
        for pose in poses:
            found = self._ends(pose, path[-1][None])
            if not len(found) or np.abs(self.robot.difference(path[-1], found[0])).max() > _JUMP:
                return None
            path.append(path[-1] + self.robot.difference(path[-1], found[0]))
        return np.array(path)

    def _ends(self, pose: Floats, seeds: Floats) -> Floats:
        ends, distance, angle = self._chain.inverse(
            seeds, self._joint, self._tool, pose, True, self._limits, _ITERATIONS
        )
        return ends[(distance <= POSITION_TOLERANCE) & (angle <= ANGLE_TOLERANCE)]


def line_poses(rest: Floats, line: Line, forward: bool, margin: float = 0.0) -> list[Floats]:
    """Poses of the tool from ``rest`` (4, 4) outwards: back along an approach, or ``forward`` along a retreat.

    The first is ``RELEASE`` beyond the ``margin`` (m) away from the rest, or at the line's end where that is nearer,
    the others up to ``STEP`` apart. One pose at least: without a line it is the rest itself.
    """
    axis = np.array(line.axis) if line.frame == "world" else rest[:3, :3] @ np.array(line.axis)
    first = min(RELEASE + margin, line.distance)
    rest_of = line.distance - first
    count = int(np.ceil(rest_of / STEP - 1e-9))
    distances = [first, *(first + rest_of * (np.arange(count) + 1) / max(count, 1))]
    found = []
    for distance in distances:
        pose = np.array(rest)
        pose[:3, 3] += (distance if forward else -distance) * axis
        found.append(pose)
    return found
