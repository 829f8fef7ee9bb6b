"""How well an arm moves its tool: Yoshikawa's manipulability w (Yoshikawa 1985) and measures in its place.

w is the product of the singular values of the tool's Jacobian J, 0 at a singular configuration. Which rows of J count
is ``arm.jacobian_rows``: "pose" (linear and angular), "translation", "rotation" or "planar" (x and y).
"""

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats, numbers
from planner.base.errors import OptionError
from planner.kinematics.arm import Arm
from planner.kinematics.forward import Chain, tool_joint
from planner.problem.options import Measure

_ALWAYS = 1e-9  # of w: rounding

BANDS = {"singular": 0.01, "poor": 0.1, "fair": 0.5}  # w below such a share of the typical one, a roadmap's median

ROWS = {"pose": (0, 6), "translation": (0, 3), "rotation": (3, 6), "planar": (0, 2)}
_UNIT = {"pose": "m³", "translation": "m³", "rotation": "", "planar": "m²"}


def rows_of(arm: Arm) -> tuple[int, int]:
    """The first row of the tool's Jacobian that counts, and the one behind the last; linear rows come first."""
    return ROWS[arm.jacobian_rows]


def measure_name(measure: Measure) -> str:
    """The name of a built-in measure, or the qualified name of a function."""
    return measure if isinstance(measure, str) else f"{measure.__module__}.{measure.__qualname__}"


def unit_of(arm: Arm) -> str:
    """The unit of the arm's measure; empty where it has none, or where only its author knows it."""
    if arm.measure == "min-singular-value":
        return "" if arm.jacobian_rows == "rotation" else "m"
    return _UNIT[arm.jacobian_rows] if arm.measure in ("yoshikawa", "joint-limits") else ""


def full_jacobians(arm: Arm, q: Floats, frame: int | None = None) -> Floats:
    """The Jacobians (n, 6, dof) of a frame (the tool) at configurations (n, dof), in world axes at its origin.

    Linear rows first (m/rad), then angular ones.
    """
    model, aligned, chain = arm.model, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED, Chain.from_arm(arm)
    data, matrices = model.createData(), np.zeros((len(q), 6, model.nv))
    frame = arm.tool_id if frame is None else frame
    for k, row in enumerate(chain.values(q)):
        # Pinocchio drops an axis where there is one joint
        matrices[k] = pin.computeFrameJacobian(model, data, row, frame, aligned).reshape(6, model.nv)
    return matrices @ chain.coupling if chain.follows else matrices


def jacobians(arm: Arm, q: Floats) -> Floats:
    """The rows (n, rows, dof) of the tool's Jacobians that ``arm.jacobian_rows`` names, at configurations (n, dof).

    Translation and pose manipulability rank configurations differently (rank correlation 0.6 to 0.75), so the robot
    file or the objective chooses.
    """
    return full_jacobians(arm, q)[:, slice(*rows_of(arm))]


def manipulability(arm: Arm, q: Floats) -> Floats:
    """w (n,), or the arm's own measure, at configurations (n, dof): 0 at a singular one, larger far from them.

    By orthogonalising the rows of J one after the other, as the lengths that are left multiply to that product; the
    determinant in sqrt(det(J Jᵀ)) comes out negative by rounding in about half of all singular configurations. Modified
    Gram-Schmidt is as good as LAPACK's QR here (Björck 1967). Unit m^3 for six rows, m^3 for three, m^2 for two.
    """
    q = np.atleast_2d(np.asarray(q, dtype=float))
    if arm.measure != "yoshikawa":
        return evaluate_measure(arm, q)
    return Chain.from_arm(arm).native.manipulability(q, *tool_and_rows(arm))


def node_manipulability(arm: Arm, q: Floats) -> Floats:
    """The same w (n,) by Pinocchio's Jacobians, as every node of a roadmap has it: 10 us a configuration (n, dof).

    :func:`manipulability` is our own compiled code, for the many states between nodes; the tests hold the two equal.
    """
    q = np.atleast_2d(np.asarray(q, dtype=float))
    if arm.measure != "yoshikawa":
        return evaluate_measure(arm, q)
    rows = jacobians(arm, q)
    return _volumes(rows if rows.shape[1] <= rows.shape[2] else rows.swapaxes(1, 2))


def manipulability_along(arm: Arm, start: Floats, delta: Floats, shares: Floats) -> Floats:
    """w (n, k) along straight motions from ``start`` by ``delta`` (n, dof), after each of ``shares`` (k,) of them."""
    if arm.measure != "yoshikawa":
        states = start[:, None] + shares[:, None] * delta[:, None]
        return evaluate_measure(arm, states.reshape(-1, arm.dof)).reshape(states.shape[:2])
    return Chain.from_arm(arm).native.manipulability_along(start, delta, shares, *tool_and_rows(arm))


def is_always_singular(arm: Arm) -> bool:
    """Whether w is 0 in every one of 16 random configurations, as where the tool's origin lies on the last axis."""
    q = np.random.default_rng(0).uniform(arm.lower, arm.upper, size=(16, arm.dof))
    return bool(manipulability(arm, q).max() < _ALWAYS)


def evaluate_measure(arm: Arm, q: Floats) -> Floats:
    """The arm's measure (n,) in place of w at configurations (n, dof); :class:`OptionError` where it is negative."""
    if callable(arm.measure):
        values = numbers("manipulability", arm.measure(q), (len(q),))
        if (values < 0.0).any():
            raise OptionError(f"manipulability must not be negative, got {values.min():g}: give a measure from 0 up.")
        return values
    rows = jacobians(arm, q)
    if arm.measure == "joint-limits":
        mobile: Floats = rows * np.sqrt(_mobility(arm, q))[:, None]
        return np.linalg.svd(mobile, compute_uv=False).prod(axis=1)
    values = np.asarray(np.linalg.svd(rows, compute_uv=False), dtype=np.float64)
    if arm.measure == "min-singular-value":
        return values[:, -1]
    return np.divide(values[:, -1], values[:, 0], out=np.zeros(len(q)), where=values[:, 0] > 0.0)


def _mobility(arm: Arm, q: Floats) -> Floats:
    """(n, dof) 1 / (1 + |dH/dq|), from 1 in the middle of a joint's range to 0 at its limits (Chan and Dubey 1995).

    H = sum (u - l)² / (4 (u - q)(q - l)) over the limits l and u of the joints; a continuous joint has none.
    """
    below, above = np.maximum(q - arm.lower, 0.0), np.maximum(arm.upper - q, 0.0)
    slope = (arm.upper - arm.lower) ** 2 * np.abs(below - above)
    room = 4.0 * (below * above) ** 2
    return np.where(arm.continuous, 1.0, room / (room + slope))


def _volumes(rows: Floats) -> Floats:
    """(n,) the volumes that the rows (n, k, m) of matrices span, k at most m, by modified Gram-Schmidt."""
    rows, volumes = rows.copy(), np.ones(len(rows))
    for k in range(rows.shape[1]):
        lengths = np.sqrt(np.einsum("nm,nm->n", rows[:, k], rows[:, k]))
        volumes *= lengths
        unit = rows[:, k] / np.where(lengths > 0.0, lengths, 1.0)[:, None]
        rows[:, k + 1 :] -= np.einsum("nkm,nm->nk", rows[:, k + 1 :], unit)[:, :, None] * unit[:, None]
    return volumes


def tool_and_rows(arm: Arm) -> tuple[int, Floats, tuple[int, int]]:
    """The joint that carries the tool, where the tool is in its frame, and :func:`rows_of` its Jacobian."""
    joint, placement = tool_joint(arm)
    return joint, placement.translation, rows_of(arm)
