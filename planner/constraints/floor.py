"""Proofs that Yoshikawa's manipulability w stays above a floor along curves.

Column i of the tool's Jacobian is (z_i x (p - p_i), z_i) for a revolute joint about z_i. A rotation dq_k of joint k
rotates everything that it carries: for k <= i the linear part changes at the rate z_k x (z_i x (p - p_i)) and z_i at
the rate z_k x z_i; for k > i only p moves, by z_k x (p - p_k). With R_j at least the tool's distance from axis j, the
rate of column i is at most (R_max(i,k), [k < i]) in its linear and angular part. If joints move by at most ``spread``,
J changes by at most e in the Frobenius norm, so no singular value decreases by more than e (Weyl 1912), and w, their
product, is at least prod max(0, sigma_i - e).
"""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, numbers
from planner.base.polynomials import bernstein, derivative, evaluate, part
from planner.constraints.tool_bound import column_rates
from planner.kinematics.manipulability import jacobians, rows_of
from planner.robot.robot import Robot

_FINEST = 2e-5  # rad (m): intervals with less joint motion are not halved
_SAFE = 1e-9  # relative: rounding of Jacobians and singular values
_SHORTEST = 1e-9  # m: least unit of length


@dataclass(frozen=True, eq=False)
class FloorProofs:
    """Verdicts on m curves: ``holds`` if w is proven to be at least the floor, ``broken`` if below.

    If neither is True, w is too close to the floor for a proof. ``lowest`` (m,) is a lower bound on w for curves that
    hold, else the smallest sampled w.
    """

    holds: Bools
    broken: Bools
    lowest: Floats


class ManipulabilityBound:
    """Lower bounds on a robot's w around configurations.

    bound = ManipulabilityBound(robot)
    w, least = bound(q, spread)       # w at q (n,), and its lower bound if no joint is off by more than spread
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        linear, angular = column_rates(robot)
        first, stop = rows_of(robot)
        # linear rows in units of a length weigh like angular ones; their product then wants that length back
        self._unit = max(0.5 * float(linear.max()), _SHORTEST) if (first, stop) == (0, 6) and robot.dof >= 6 else 1.0
        self._rate = np.hypot(linear / self._unit if first == 0 else 0.0, angular if stop == 6 else 0.0)

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
    """Prove that w is at least ``floor`` (m,) on curves sum_k c_k s^k, (m, degree + 1, dof), s in [0, 1].

    With several tools, w of each one is. Intervals that the bound at their middle does not cover are halved. Raises
    :class:`ArrayError` for wrong shapes or values that are not finite.
    """
    coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", robot.dof))
    m = len(coefficients)
    if robot.other_tools:
        each = [prove_floor(one, coefficients, floor) for one in robot.with_each_tool]
        least, broken = np.min([one.lowest for one in each], axis=0), np.any([one.broken for one in each], axis=0)
        return FloorProofs(np.all([one.holds for one in each], axis=0), broken, least)
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
