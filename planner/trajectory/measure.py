"""What can be measured along a joint path from any source: manipulability, lengths, clearance, the first contact."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints, cut, parts_of
from planner.base.resolutions import CLEARANCE_ALONG_PATH, RECHECK, W_ALONG_PATH
from planner.collision.checker import CollisionChecker
from planner.collision.looks import Clearance, Seen, dense_states, first_seen, straight
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.robot.robot import Robot

_STRAIGHT = 1e-3  # rad: a smaller change of direction is no corner


def dense_path(path: Floats, step: float = W_ALONG_PATH) -> Floats:
    """Configurations (n, dof) along a joint path, no joint moving more than ``step`` (rad) between two of them."""
    return dense_segments(path, step)[0]


def dense_segments(path: Floats, step: float) -> tuple[Floats, Ints]:
    """Configurations (n, dof) as :func:`dense_path` has them, and the segment (n,) that each ends or lies on."""
    parts = parts_of(np.abs(np.diff(path, axis=0)).max(axis=1, initial=0.0), step)
    return cut(path, parts), np.concatenate([[0], np.repeat(np.arange(len(parts)), parts)])


@dataclass(frozen=True)
class PathMeasures:
    """What every report says of a joint path: w at its smallest and in the mean, lengths in rad and m."""

    w_min: float
    w_mean: float
    joint_length: float
    workspace_length: float


def measure_path(robot: Robot, path: Floats) -> PathMeasures:
    """Manipulability at states ``W_ALONG_PATH`` apart, and both lengths, of a joint path (k, dof)."""
    w = path_manipulability(robot, path)
    return PathMeasures(float(w.min()), float(w.mean()), joint_path_length(path), tool_path_length(robot, path))


def path_manipulability(robot: Robot, path: Floats) -> Floats:
    """w (n,) sampled densely along a joint path."""
    return manipulability(robot, dense_path(path))


def tool_path_length(robot: Robot, path: Floats) -> float:
    """Length (m) of the tool's path along a joint path."""
    return float(np.linalg.norm(np.diff(tool_positions(robot, dense_path(path)), axis=0), axis=1).sum())


def joint_path_length(path: Floats) -> float:
    """Sum of the Euclidean lengths (rad) of a joint path's segments."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def corners(path: Floats) -> int:
    """How often a joint path (k, dof) changes its direction, by more than 0.001 rad: a robot stops or blends there."""
    step = np.diff(path, axis=0)
    far = np.linalg.norm(step, axis=1)
    ahead = step[far > 0] / far[far > 0][:, None]
    return int((np.linalg.norm(np.diff(ahead, axis=0), axis=1) > _STRAIGHT).sum())


def path_contact(checker: CollisionChecker, path: Floats, step: float = RECHECK) -> Seen | None:
    """The first contact along a joint path sampled every ``step`` metres of motion, without bounds or proofs."""
    start = path[:-1] if len(path) > 1 else path
    return first_seen(checker, straight(start, np.diff(path, axis=0) if len(path) > 1 else 0.0 * path), step)


def path_clearance(checker: CollisionChecker, path: Floats) -> tuple[Floats, Floats]:
    """Configurations (n, dof) along a joint path, ``CLEARANCE_ALONG_PATH`` apart, and the clearance (n,) m at each."""
    along = (dense_states(checker.world, a, b - a, CLEARANCE_ALONG_PATH)[0] for a, b in itertools.pairwise(path))
    q = np.concatenate([path[:1], *(states[1:] for states in along)])
    return q, Clearance(checker)(q)
