"""roboplan's time parametrization over the same path, in an environment of its own, and what its samples keep to."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.looks import motion_contact
from benchmarks.others import roboplan_runner
from benchmarks.others.elsewhere import answer_of
from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker
from planner.robot.robot import Robot
from planner.trajectory.limits import MotionLimits
from planner.trajectory.trajectory import Trajectory

_WAIT = 60.0  # s


def roboplan_law(python: str, path: Floats, judge: CollisionChecker, limits: MotionLimits) -> Any:
    """Columns of a row: its duration, its largest share of a limit at its own samples, and its first contact."""
    found = time_by_roboplan_elsewhere(python, path, judge.robot, limits)
    if "times" not in found:
        return {"roboplan_contact": f"not timed: {found['message']}"}
    shares = [np.abs(found["qd"]) / limits.velocity, np.abs(found["qdd"]) / limits.acceleration]
    made = roboplan_motion(found, limits)
    return {
        "roboplan_s": made.duration,
        "roboplan_share": float(np.max(shares)),
        "roboplan_contact": motion_contact(made, judge),
    }


def roboplan_motion(found: dict[str, Any], limits: MotionLimits) -> Trajectory:
    """What a controller makes of the samples of an answer: cubics through positions and velocities."""
    times, q, qd = (np.array(found[key]) for key in ("times", "q", "qd"))
    return Trajectory.from_points(limits.joints, times, q, qd)


def time_by_roboplan_elsewhere(python: str, path: Floats, robot: Robot, limits: MotionLimits) -> dict[str, Any]:
    """The answer of :mod:`benchmarks.others.roboplan_runner` about a path (k, dof)."""
    problem = describe_robot(robot, limits) | {"path": path.tolist()}
    return answer_of("roboplan", python, roboplan_runner.__file__, problem, _WAIT, ["time"])


def describe_robot(robot: Robot, limits: MotionLimits) -> dict[str, Any]:
    """Return the URDF, the joints and the limits (without jerk) of a robot for another environment."""
    return {
        "urdf": robot.source.xml,
        "package_dirs": robot.source.package_dirs,
        "joints": list(robot.joints),
        "velocity": limits.velocity.tolist(),
        "acceleration": limits.acceleration.tolist(),
    }
