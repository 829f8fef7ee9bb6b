"""The joint values among which trees grow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.robot.robot import Robot, shorter_way


@dataclass(frozen=True, eq=False)
class JointSpace:
    """Joint values between ``lower`` and ``upper`` (dof,), rad; those that ``wrap`` are angles on a circle."""

    lower: Floats
    upper: Floats
    wrap: Bools

    @staticmethod
    def of(robot: Robot) -> JointSpace:
        return JointSpace(robot.lower, robot.upper, robot.continuous)

    def holds(self, q: Floats) -> Bools:
        """(n,) which configurations (n, dof) lie within; angles that wrap always do."""
        return np.all(self.wrap | ((self.lower <= q) & (q <= self.upper)), axis=1)

    def difference(self, a: Floats, b: Floats) -> Floats:
        """The joint motion from a to b: in the shorter direction where a joint wraps."""
        return shorter_way(b - a, self.wrap)
