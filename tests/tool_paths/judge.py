"""Tool paths for tests, and a judge of motions along them that shares nothing with the proofs: Pinocchio, densely."""

from typing import Any

import numpy as np
import pinocchio as pin

from planner.robot.robot import Robot
from planner.tool_paths.file import read_tool_path
from planner.tool_paths.tool_path import ToolPath

DOWN = [0, 0, -1]


def line_of(positions: Any, tube: tuple[float, float] = (1e-3, 8.7e-3), **orientation: Any) -> ToolPath:
    """A path through positions of one orientation; the tool's z axis down where none is given."""
    how = orientation or {"axis": DOWN}
    points = [{"position": [float(x) for x in position], **how} for position in positions]
    return read_tool_path({"points": points, "tube": {"position": tube[0], "angle": tube[1]}})


def raster(rows: int, columns: int, step: float, origin: Any, **more: Any) -> ToolPath:
    """Rows along y, there and back."""
    points = []
    for row in range(rows):
        along = np.arange(columns)[:: -1 if row % 2 else 1] * step
        points += [np.add(origin, [row * step, y, 0.0]) for y in along]
    return line_of(points, **more)


def pose_of(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation (3, 3) and position (3,) of the tool at a configuration (dof,)."""
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return data.oMf[robot.tool_id].rotation, data.oMf[robot.tool_id].translation


def outside(path: ToolPath, robot: Robot, q: np.ndarray) -> float:
    """The most by which poses at configurations (n, dof) leave the tube, as a share of it: 1 is its boundary.

    Of each pose the best of 41 points of each line counts, on either side of the nearest one.
    """
    data, worst = robot.model.createData(), 0.0
    for row in q:
        pin.framesForwardKinematics(robot.model, data, row)
        pose = data.oMf[robot.tool_id]
        worst = max(worst, min(_share(path, pose, k) for k in range(len(path.positions) - 1)))
    return worst


def _share(path: ToolPath, pose: pin.SE3, k: int) -> float:
    begin, way = path.positions[k], path.positions[k + 1] - path.positions[k]
    middle, reach = (pose.translation - begin) @ way / (way @ way), path.tube.position / np.linalg.norm(way)
    nearest = np.linalg.norm(begin + np.clip(middle, 0.0, 1.0) * way - pose.translation) / path.tube.position
    if nearest > 3.0:
        return float(nearest)
    best = np.inf
    for u in np.clip(middle + reach * np.linspace(-1, 1, 41), 0.0, 1.0):
        near = np.linalg.norm(begin + u * way - pose.translation) / path.tube.position
        if near < best:
            best = min(best, max(near, _turned(path, pose.rotation, k, u)))
    return float(best)


def great_arc(a: np.ndarray, b: np.ndarray, u: float) -> np.ndarray:
    """The unit vector (3,) a share ``u`` of the way from one to another, which turns by as little as it can."""
    axis = np.cross(a, b)
    sine = np.linalg.norm(axis)
    return pin.exp3(u * np.arctan2(sine, a @ b) / sine * axis) @ a if sine > 1e-12 else a


def _turned(path: ToolPath, rotation: np.ndarray, k: int, u: float) -> float:
    if not (path.free[k] or path.free[k + 1]):
        wanted = path.turns[k] @ pin.exp3(u * pin.log3(path.turns[k].T @ path.turns[k + 1]))
        return float(np.linalg.norm(pin.log3(wanted.T @ rotation)) / path.tube.angle)
    low, high = (cone or path.tube.angle for cone in path.cones[k : k + 2])
    z = great_arc(path.turns[k, :, 2], path.turns[k + 1, :, 2], u)
    return float(np.arctan2(np.linalg.norm(np.cross(z, rotation[:, 2])), z @ rotation[:, 2]) / (low + u * (high - low)))


def passes_by(path: ToolPath, robot: Robot, q: np.ndarray, k: int) -> float:
    """How near to the pose of point ``k`` the tool comes at configurations (n, dof), as a share of the tube."""
    off = []
    for rotation, position in (pose_of(robot, row) for row in q):
        turned = np.linalg.norm(pin.log3(path.turns[k].T @ rotation)) / path.tube.angle
        off.append(max(turned, np.linalg.norm(position - path.positions[k]) / path.tube.position))
    return float(min(off))
