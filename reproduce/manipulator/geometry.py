"""The shape of a tool's path in space: how much it turns, where it kinks, the distance of two of them."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, lengths_along
from planner.kinematics.forward import tool_positions
from planner.robot.robot import Robot
from planner.trajectory.measure import dense_path

SPACING = 0.005
"""m between two points of an evenly spaced tool path."""


def sampled_tool_path(robot: Robot, path: Floats, spacing: float = SPACING) -> Floats:
    """Tool positions (n, 3) m along a joint path (k, dof), about ``spacing`` (m) of travel from each to the next."""
    dense = tool_positions(robot, dense_path(path))
    along = lengths_along(dense)
    wanted = np.linspace(0.0, along[-1], max(2, round(along[-1] / spacing) + 1))
    return np.column_stack([np.interp(wanted, along, column) for column in dense.T])


def turning(points: Floats) -> float:
    """Total curvature (rad) of a tool path (n, 3): the angles between its successive steps, summed."""
    steps = np.diff(points, axis=0)
    return float(_angles(steps[:-1], steps[1:]).sum())


def kinks(robot: Robot, path: Floats) -> Floats:
    """The angle (rad) by which the tool changes direction at each inner waypoint (k - 2,) of a joint path."""
    linear = [robot.jacobian(q)[:3] for q in path[1:-1]]
    before, after = np.diff(path, axis=0)[:-1], np.diff(path, axis=0)[1:]
    arriving = np.array([J @ step for J, step in zip(linear, before, strict=True)]).reshape(-1, 3)
    leaving = np.array([J @ step for J, step in zip(linear, after, strict=True)]).reshape(-1, 3)
    return _angles(arriving, leaving)


def mean_distance(a: Floats, b: Floats) -> float:
    """The distance (m) of two evenly spaced tool paths: the mean over both to the nearest point of the other."""
    apart = np.linalg.norm(a[:, None] - b[None], axis=2)
    return float(0.5 * (apart.min(axis=1).mean() + apart.min(axis=0).mean()))


def _angles(a: Floats, b: Floats) -> Floats:
    """Angles (n,) between rows; 0 where one of them has no length."""
    across, along = np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ij,ij->i", a, b)
    return np.arctan2(across, along)
