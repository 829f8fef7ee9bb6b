"""Yoshikawa's manipulability, w = product of the singular values of the Jacobian (Yoshikawa 1985), and its proofs.

Column i of the tool's Jacobian is (z_i x (p - p_i), z_i) for a joint that turns about z_i. Turning joint k by dq_k
turns all that it carries, so that for k <= i the linear part changes at the rate z_k x (z_i x (p - p_i)) and z_i at
the rate z_k x z_i; for k > i only p moves, by z_k x (p - p_k), and z_i stays. With R_j no less than the tool's
distance from axis j the rate of column i is at most (R_max(i,k), [k < i]) in its linear and its angular part. Where
joints move by no more than ``spread``, J changes by no more than e in the Frobenius norm, so no singular value falls
by more than e (Weyl 1912), and w, their product, is at least prod max(0, sigma_i - e).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from planner.base.arrays import Bools, Floats, numbers
from planner.base.polynomials import bernstein, derivative, evaluate, part
from planner.kinematics.forward import Chain, tool_joint
from planner.kinematics.tool_bound import column_rates
from planner.robot.robot import Robot

_FINEST = 2e-5  # rad (m): intervals on which no joint moves further are not halved again
_SAFE = 1e-9  # relative: rounding of Jacobians and singular values
_SHORTEST = 1e-9  # m: a tool that reaches less far from every axis counts as reaching as far

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


@dataclass(frozen=True, eq=False)
class FloorProofs:
    """For each of m curves: ``holds`` where w is proven to stay at or above its floor, ``broken`` where it falls below.

    Where neither is True w comes so close to the floor that nothing is proven. ``lowest`` (m,) is a lower bound on w
    along the curves whose floor holds, and the smallest w seen along the others.
    """

    holds: Bools
    broken: Bools
    lowest: Floats


class ManipulabilityBound:
    """Lower bounds on a robot's w around configurations.

    bound = ManipulabilityBound(robot)
    w, least = bound(q, spread)       # w at q (n,), and a bound on w wherever no joint is further off than spread
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        linear, angular = column_rates(robot)
        columns, rows = robot.dof, ROWS[robot.manipulability].stop
        # linear rows in units of a length weigh like angular ones; their product then wants that length back
        self._unit = max(0.5 * float(linear.max()), _SHORTEST) if 6 == rows <= columns else 1.0
        self._rate = np.hypot(linear / self._unit, angular if rows == 6 else 0.0)

    def __call__(self, q: Floats, spread: Floats) -> tuple[Floats, Floats]:
        matrices = jacobians(self.robot, q)
        scale = 1.0
        if self._unit != 1.0:
            matrices[:, :3] /= self._unit
            scale = self._unit**3
        values = np.linalg.svd(matrices, compute_uv=False)
        change = np.sqrt((np.einsum("ik,nk->ni", self._rate, spread) ** 2).sum(axis=1))
        least = np.maximum(values * (1.0 - _SAFE) - change[:, None], 0.0).prod(axis=1)
        return scale * values.prod(axis=1), scale * least


def prove_floor(robot: Robot, coefficients: Floats, floor: Floats | float) -> FloorProofs:
    """Whether w stays at or above ``floor`` (m,) on the curves sum_k c_k s^k, s in [0, 1], (m, degree + 1, dof).

    Every interval is looked at in its middle; what the bound there does not cover is halved. :class:`ArrayError` for
    arrays of other shapes, or with what is no finite number.
    """
    coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", robot.dof))
    m = len(coefficients)
    bound, slopes = ManipulabilityBound(robot), derivative(coefficients)
    floor = numbers("floor", np.broadcast_to(floor, (m,)), (m,))
    proofs = FloorProofs(np.ones(m, dtype=bool), np.zeros(m, dtype=bool), np.full(m, np.inf))
    curve, low, high = np.arange(m), np.zeros(m), np.ones(m)
    while len(curve):
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        speed = np.abs(bernstein(part(slopes[curve], low, high))).max(axis=1) * (1.0 + _SAFE)
        spread = half[:, None] * speed
        w, least = bound(evaluate(coefficients[curve], middle), spread)
        covered, below = least >= floor[curve], w < floor[curve]
        proofs.broken[curve[below]] = True
        stuck = ~covered & (below | ~(spread.max(axis=1) >= _FINEST))
        proofs.holds[curve[stuck]] = False
        np.minimum.at(proofs.lowest, curve, np.where(covered, least, w))
        again = ~covered & proofs.holds[curve]
        curve, low, middle, high = curve[again], low[again], middle[again], high[again]
        curve, low, high = np.tile(curve, 2), np.concatenate([low, middle]), np.concatenate([middle, high])
    return proofs
