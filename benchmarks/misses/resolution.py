"""The rule by which OMPL looks at an edge unless told otherwise, so that what it misses can be counted."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats
from planner.models.robot import Robot

FRACTION = 0.01
"""OMPL's default longest valid segment, as a share of the space's extent."""


def states_by_ompls_rule(robot: Robot, start: Floats, delta: Floats) -> Floats:
    """The configurations (n, dof) that OMPL's DiscreteMotionValidator would check along an edge, both ends included.

    With its default settings it divides the edge into the least number of equal parts no longer than ``FRACTION``
    of the space's largest extent: for joints with limits, one real vector space, the diagonal of its box. A space with
    continuous joints is a compound of one space a joint, as this planner makes it for OMPL, and takes the
    largest of their numbers (a circle's extent is pi).
    """
    length = np.abs(delta)
    if robot.continuous.any():
        extent = np.where(robot.continuous, np.pi, robot.upper - robot.lower)
        parts = int(np.ceil(length / (FRACTION * extent)).max(initial=0.0))
    else:
        extent = float(np.linalg.norm(robot.upper - robot.lower))
        parts = int(np.ceil(np.linalg.norm(delta) / (FRACTION * extent)))
    return start + np.linspace(0.0, 1.0, max(parts, 1) + 1)[:, None] * delta
