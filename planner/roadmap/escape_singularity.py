"""Paths out of badly conditioned configurations: proven motions along which manipulability rises."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, length
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability

_STEP = 0.05  # rad
_STEPS = 80
_TRIES = 12  # directions beside the steepest one, where that is blocked
_SPREAD = 1.4  # length of what is added to the steepest direction, which has length 1
_STATES = np.linspace(0.0, 1.0, 6)[1:]  # of a step at which w must have risen
_EPS = 1e-4  # rad, finite differences


def ascend_manipulability(prover: EdgeProver, q: Floats, floor: float) -> Floats:
    """A path (k, dof) from ``q`` up to manipulability ``floor``, as far as small proven steps uphill lead.

    w rises from each sampled state to the next. Its last row falls short of ``floor`` where every step up is blocked.
    """
    robot, rng = prover.robot, np.random.default_rng(0)
    rows, w = [q], float(manipulability(robot, q[None])[0])
    while w < floor and len(rows) <= _STEPS:
        found = _step(prover, rows[-1], w, rng)
        if found is None:
            break
        rows.append(found)
        w = float(manipulability(robot, found[None])[0])
    return robot.normalise(np.array(rows))


def _step(prover: EdgeProver, q: Floats, w: float, rng: np.random.Generator) -> Floats | None:
    """The proven step that gains most w, among those along which w rises everywhere."""
    robot = prover.robot
    slope = manipulability(robot, q + _EPS * np.eye(robot.dof)) - w
    uphill = slope / max(length(slope), 1e-300)
    directions = np.vstack([uphill, uphill + _SPREAD * rng.normal(size=(_TRIES, robot.dof)) / np.sqrt(robot.dof)])
    directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-300)
    ends = q + _STEP * directions
    ends = np.where(robot.continuous, ends, np.clip(ends, robot.lower, robot.upper))
    delta = ends - q
    along = manipulability(robot, (q + _STATES[:, None, None] * delta).reshape(-1, robot.dof))
    along = np.vstack([np.full(len(ends), w), along.reshape(len(_STATES), -1)])
    rising = np.flatnonzero((np.diff(along, axis=0) > 0).all(axis=0))
    for row in rising[np.argsort(-along[-1, rising], kind="stable")]:
        if prover.free(q[None], delta[row][None])[0]:
            return ends[row]
    return None
