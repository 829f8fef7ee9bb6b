"""Where paths shorter than one that is known may pass: ellipsoids whose foci are a start and a goal."""

from __future__ import annotations

import math

import numpy as np

from planner.base.arrays import Floats
from planner.roadmap.joint_space import JointSpace
from planner.robot.robot import Robot

_THINNEST = 1e-9  # rad: in a box without any extent OMPL cannot sample
_ROUNDING = 1e-9  # relative: a straight path is as long as its ends are apart


class InformedSet:
    """The states that a path from a start to a goal no longer than ``longest`` (rad) may pass.

    Informed RRT* (Gammell, Srinivasa, Barfoot, 2014) samples it; a tree that is to stay inside asks :meth:`holds`, and
    samples ``space``, the least box around the set within joint limits.
    """

    def __init__(self, robot: Robot, starts: Floats, goals: Floats, longest: float) -> None:
        """Of ``starts`` (s, dof) and ``goals`` (g, dof), one of each no farther apart than ``longest``."""
        self._robot, self._starts, self._goals = robot, starts, goals
        self._foci, self._wraps = (starts.tolist(), goals.tolist()), bool(robot.continuous.any())
        self.longest = (1.0 + _ROUNDING) * longest
        self.space = self._box()

    def holds(self, q: list[float]) -> bool:
        """Whether ``q``, dof numbers, lies in the set."""
        if self._wraps:
            ends, robot = (self._starts, self._goals), self._robot
            near = [np.linalg.norm(robot.difference(rows, np.array(q)), axis=1).min() for rows in ends]
        else:  # a tree asks at every step: a quarter of the time that arrays take
            near = [min([math.dist(q, row) for row in rows]) for rows in self._foci]
        return near[0] + near[1] <= self.longest

    def _box(self) -> JointSpace:
        robot, longest = self._robot, self.longest
        if not math.isfinite(longest):
            return JointSpace.of(robot)
        apart = robot.difference(self._starts[:, None], self._goals[None])
        middle, apart = (self._starts[:, None] + 0.5 * apart).reshape(-1, robot.dof), apart.reshape(-1, robot.dof)
        far = (apart * apart).sum(axis=1, keepdims=True)
        # half the box of an ellipsoid: half its long axis squared, seen along a joint, and its short axes likewise
        along = apart * apart / np.maximum(far, 1e-300)
        half = 0.5 * np.sqrt(along * longest**2 + (1.0 - along) * np.maximum(longest**2 - far, 0.0))
        within = far[:, 0] <= longest**2
        half = half if half[within].max() > _THINNEST else np.full_like(half, _THINNEST)
        lower = np.maximum((middle - half)[within].min(axis=0), robot.lower)
        upper = np.minimum((middle + half)[within].max(axis=0), robot.upper)
        turns = robot.continuous  # these have no bounds
        return JointSpace(np.where(turns, robot.lower, lower), np.where(turns, robot.upper, upper), turns)
