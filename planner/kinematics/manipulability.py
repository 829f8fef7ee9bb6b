"""Yoshikawa's manipulability, w = product of the singular values of the Jacobian (Yoshikawa 1985)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats
from planner.kinematics.forward import Chain, tool_joint
from planner.robot.robot import Robot

ROWS = {"pose": slice(0, 6), "translation": slice(0, 3), "planar": slice(0, 2)}


def jacobian(robot: Robot, q: Floats) -> Floats:
    """The tool's Jacobian (rows, dof) at one configuration, in world axes at the tool's origin.

    Linear rows first (m/rad), then angular ones; ``robot.manipulability`` says which are kept. Translation and pose
    manipulability rank configurations differently (rank correlation 0.6 to 0.75), so the robot file chooses.
    """
    return jacobians(robot, np.asarray(q, dtype=float)[None])[0]


def jacobians(robot: Robot, q: Floats) -> Floats:
    """The :func:`jacobian` (n, rows, dof) at each of several configurations (n, dof)."""
    model, aligned, chain = robot.model, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED, Chain.of(robot)
    data, matrices = model.createData(), np.zeros((len(q), 6, model.nv))
    for k, row in enumerate(chain.values(q)):
        # Pinocchio drops an axis where there is one joint
        matrices[k] = pin.computeFrameJacobian(model, data, row, robot.tool_id, aligned).reshape(6, model.nv)
    rows = matrices[:, ROWS[robot.manipulability]]
    return rows @ chain.coupling if chain.follows else rows


def manipulability(robot: Robot, q: Floats) -> Floats:
    """w (n,) at configurations (n, dof): 0 at a singular one, larger where the tool moves well in every direction.

    By orthogonalising the rows of J one after the other, as the lengths that are left multiply to that product; the
    determinant in sqrt(det(J Jᵀ)) comes out negative by rounding in about half of all singular configurations. Modified
    Gram-Schmidt is as good as LAPACK's QR here (Björck 1967). Unit m^3 for six rows, m^3 for three, m^2 for two.
    """
    return Chain.of(robot).native.manipulability(np.atleast_2d(np.asarray(q, dtype=float)), *measured_tool(robot))


def node_manipulability(robot: Robot, q: Floats) -> Floats:
    """The same w (n,) by Pinocchio's Jacobians, as every node of a roadmap has it: 10 us a configuration (n, dof).

    :func:`manipulability` is our own compiled code, for the many states between nodes; the tests hold the two equal.
    """
    rows = jacobians(robot, np.atleast_2d(np.asarray(q, dtype=float)))
    return _volumes(rows if rows.shape[1] <= rows.shape[2] else rows.swapaxes(1, 2))


def _volumes(rows: Floats) -> Floats:
    """(n,) the volumes that the rows (n, k, m) of matrices span, k at most m, by modified Gram-Schmidt."""
    rows, volumes = rows.copy(), np.ones(len(rows))
    for k in range(rows.shape[1]):
        lengths = np.sqrt(np.einsum("nm,nm->n", rows[:, k], rows[:, k]))
        volumes *= lengths
        unit = rows[:, k] / np.where(lengths > 0.0, lengths, 1.0)[:, None]
        rows[:, k + 1 :] -= np.einsum("nkm,nm->nk", rows[:, k + 1 :], unit)[:, :, None] * unit[:, None]
    return volumes


def manipulability_along(robot: Robot, start: Floats, delta: Floats, shares: Floats) -> Floats:
    """w (n, k) along straight motions from ``start`` by ``delta`` (n, dof), after each of ``shares`` (k,) of them."""
    return Chain.of(robot).native.manipulability_along(start, delta, shares, *measured_tool(robot))


def measured_tool(robot: Robot) -> tuple[int, Floats, int]:
    """The joint that carries the tool, where the tool is in its frame, and how many rows of its Jacobian count."""
    joint, placement = tool_joint(robot)
    return joint, placement.translation, ROWS[robot.manipulability].stop
