"""What came of a tool path that was to be followed, as a plan holds it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.kinematics.tool_bound import Frame
from planner.planning.record import ToolPathRecord
from planner.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """The record of ``plan.json``, and what a page draws: points (k, 3) m ``wanted``, and (n, 3) m ``reached``.

    ``rungs`` (m, dof): the solutions of inverse kinematics that were to choose from.
    """

    record: ToolPathRecord
    wanted: Floats
    reached: Floats
    rungs: Floats


def leg_line(robot: Robot, q: Floats, length: float) -> Floats:
    """(2, 3) m from where the tool is at ``q`` (dof,) to ``length`` m back along its z axis."""
    rotation, position = Frame.tool(robot).poses(robot, q[None])
    return position - np.array([[0.0], [length]]) * rotation[0, :, 2]
