"""A judge of motions along tool paths that shares nothing with their proofs: Pinocchio's frames, every 0.05 mm."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats
from planner.robot.robot import Robot
from planner.tool_paths.tool_path import ToolPath
from planner.trajectory.trajectory import Trajectory

STEP = 5e-5  # m of the tool's way between two looks
_FINE = 5e-4  # s: of the first look, which measures the way


def tool_frames(robot: Robot, q: Floats) -> tuple[Floats, Floats]:
    """Rotations (n, 3, 3) and positions (n, 3) of the tool at configurations (n, dof)."""
    data, frames = robot.model.createData(), []
    for row in q:
        pin.framesForwardKinematics(robot.model, data, row)
        frames.append((data.oMf[robot.tool_id].rotation.copy(), data.oMf[robot.tool_id].translation.copy()))
    rotation, position = zip(*frames, strict=True)
    return np.array(rotation), np.array(position)


def states_every(trajectory: Trajectory, robot: Robot, step: float = STEP) -> Floats:
    """Configurations (n, dof) of a motion between which the tool goes ``step`` (m) at most, as far as is seen."""
    times = np.linspace(trajectory.times[0], trajectory.times[-1], int(trajectory.duration / _FINE) + 2)
    way = np.linalg.norm(np.diff(tool_frames(robot, trajectory.at(times))[1], axis=0), axis=1)
    so_far = np.concatenate([[0.0], np.cumsum(way)])
    return trajectory.at(np.interp(np.arange(0.0, so_far[-1] + step, step), so_far, times))


def deviations(path: ToolPath, rotation: Floats, position: Floats) -> tuple[Floats, Floats]:
    """How far (n,) m tool frames are off the nearest line of a path, and how far (n,) rad their z axes are there.

    Of two lines that are equally near, as at a corner, the one whose axis is nearer. For paths with a free turn.
    """
    begin, way = path.positions[:-1], np.diff(path.positions, axis=0)
    least, angle = np.full(len(position), np.inf), np.full(len(position), np.inf)
    for k in range(len(way)):
        u = np.clip((position - begin[k]) @ way[k] / (way[k] @ way[k]), 0.0, 1.0)
        off = np.linalg.norm(position - begin[k] - u[:, None] * way[k], axis=1)
        z = (1 - u)[:, None] * path.turns[k, :, 2] + u[:, None] * path.turns[k + 1, :, 2]
        lean = np.arctan2(np.linalg.norm(np.cross(z, rotation[:, :, 2]), axis=1), (z * rotation[:, :, 2]).sum(axis=1))
        nearer = (off < least - 1e-12) | ((off <= least + 1e-12) & (lean < angle))
        least, angle = np.where(nearer, off, least), np.where(nearer, lean, angle)
    return least, angle
