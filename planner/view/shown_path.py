"""A path as a page shows it: the motion, what is said about it, and the field that it follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.base.resolutions import CLEARANCES_OF_MOTION, SHOWN_STATES
from planner.collision.checker import CollisionChecker
from planner.robot.robot import Robot
from planner.trajectory.measure import measure_path
from planner.trajectory.moving_obstacles import clearance_in_time
from planner.trajectory.trajectory import Trajectory

Rows = list[tuple[str, str]]
W_UNIT = {"pose": "m³", "translation": "m³", "planar": "m²"}


@dataclass(frozen=True, eq=False)
class ShownMotion:
    """A trajectory along a path, and its ``clearance`` (n,) m at evenly spaced times; None where nothing is checked."""

    trajectory: Trajectory
    clearance: Floats | None

    @property
    def states(self) -> Floats:
        """States (n, dof) at evenly spaced times, close enough to draw the tool's way by."""
        return self.trajectory.at(np.linspace(self.trajectory.times[0], self.trajectory.times[-1], SHOWN_STATES))


def shown_motion(trajectory: Trajectory, checker: CollisionChecker) -> ShownMotion:
    """A trajectory with its clearance, from its beginning to its end."""
    times = np.linspace(trajectory.times[0], trajectory.times[-1], CLEARANCES_OF_MOTION)
    clearance = clearance_in_time(trajectory, checker, times)
    return ShownMotion(trajectory, clearance if np.isfinite(clearance).all() else None)


@dataclass(frozen=True, eq=False)
class ShownPath:
    """A path (k, dof) rad, what is said about it, and where known its betas and the cost-to-go (n,) of the roadmap.

    ``costs``: Omega and D. A path with costs but without an interval is non-dominated, and no beta makes it optimal.
    With a ``motion`` the robot is shown at its times.
    """

    path: Floats
    numbers: Rows
    interval: tuple[float, float] | None = None
    cost_to_go: Floats | None = None
    costs: tuple[float, float] | None = None
    motion: ShownMotion | None = None


def path_rows(robot: Robot, path: Floats, omega: float, distance: float) -> Rows:
    """What the page says about a path: its two costs, its mean w, its lengths; the smallest w is among the lowest."""
    measures, unit = measure_path(robot, path), W_UNIT[robot.manipulability]
    return [
        ("manipulability cost Ω", f"{omega:.4f}"),
        ("distance cost D", f"{distance:.4f}"),
        (f"w mean ({unit})", f"{measures.w_mean:.3g}"),
        ("joint motion", f"{measures.joint_length:.3f} rad"),
        ("tool's path", f"{measures.workspace_length:.3f} m"),
        ("waypoints", str(len(path))),
    ]
