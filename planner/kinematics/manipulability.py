"""Yoshikawa's manipulability, w = product of the singular values of the Jacobian (Yoshikawa 1985)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats
from planner.world.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable

ROWS = {"pose": slice(0, 6), "translation": slice(0, 3), "planar": slice(0, 2)}


def jacobian(robot: Robot, q: Floats) -> Floats:
    """The tool's Jacobian (rows, dof) at one configuration, in world axes at the tool's origin.

    Linear rows first (m/rad), then angular ones; ``robot.manipulability`` says which are kept. Translation and pose
    manipulability rank configurations differently (rank correlation 0.6 to 0.75), so the robot file chooses.
    """
    return _jacobian_function(robot)(np.asarray(q, dtype=float))


def manipulability(robot: Robot, q: Floats) -> Floats:
    """w (n,) at configurations (n, dof): 0 at a singular one, larger where the tool moves well in every direction.

    By orthogonalising the rows of J one after the other, as the lengths that are left multiply to that product; the
    determinant in sqrt(det(J Jᵀ)) comes out negative by rounding in about half of all singular configurations. Unit
    m^3 for six rows, m^3 for three, m^2 for two.
    """
    q, evaluate = np.atleast_2d(np.asarray(q, dtype=float)), _jacobian_function(robot)
    rows, columns = evaluate(pin.neutral(robot.model)).shape
    stack = np.zeros((rows, columns, max(len(q), 2)))  # sums over a stack of one may be added up in another order
    for k, row in enumerate(q):
        stack[:, :, k] = evaluate(row)
    return _volumes(stack if rows <= columns else stack.swapaxes(0, 1))[: len(q)]


def _volumes(vectors: Floats) -> Floats:
    """(n,) volumes of the boxes that n sets of ``vectors`` (rows, columns, n) span; they are overwritten.

    Modified Gram-Schmidt on all sets at once: R is as good as LAPACK's (Björck 1967), quicker for large n, and its
    last bits do not depend on the processor.
    """
    volume = np.ones(vectors.shape[2])
    for k, vector in enumerate(vectors):
        size = np.sqrt((vector * vector).sum(axis=0))
        volume *= size
        along, rest = vector / np.maximum(size, 1e-300), vectors[k + 1 :]
        rest -= along * (along * rest).sum(axis=1)[:, None]
    return volume


def _jacobian_function(robot: Robot) -> Callable[[Floats], Floats]:
    model, frame, rows = robot.model, robot.tool_id, ROWS[robot.manipulability]
    data = model.createData()
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def evaluate(q: Floats) -> Floats:
        # Pinocchio drops an axis where there is one joint
        return pin.computeFrameJacobian(model, data, q, frame, aligned).reshape(6, model.nv)[rows]

    return evaluate
