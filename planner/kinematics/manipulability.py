"""Manipulability w of an arm (Yoshikawa 1985) and the measures that may replace it.

w is the product of the singular values of the tool's Jacobian J, 0 at a singular configuration. ``arm.jacobian_rows``
names its rows: "pose" (linear and angular), "translation", "rotation" or "planar" (x and y). An arm with several tools
has the least w of any of them: it is as badly conditioned as its worst tool.
"""

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from planner.base.arrays import Floats, Ints, numbers
from planner.base.errors import OptionError
from planner.kinematics.arm import Arm
from planner.kinematics.forward import Chain, tool_joint
from planner.problem.options import Measure

_ALWAYS = 1e-9  # of w: rounding

BANDS = {"singular": 0.01, "poor": 0.1, "fair": 0.5}  # upper ends, as shares of the median w of a roadmap

ROWS = {"pose": (0, 6), "translation": (0, 3), "rotation": (3, 6), "planar": (0, 2)}
_UNIT = {"pose": "m³", "translation": "m³", "rotation": "", "planar": "m²"}


def rows_of(arm: Arm) -> tuple[int, int]:
    """Return the first and the past-the-end row of the tool's Jacobian for w; linear rows come first."""
    return ROWS[arm.jacobian_rows]


def measure_name(measure: Measure) -> str:
    """Return the name of a built-in measure, or the qualified name of a function."""
    return measure if isinstance(measure, str) else f"{measure.__module__}.{measure.__qualname__}"


def unit_of(arm: Arm) -> str:
    """Return the unit of the arm's measure; empty for none, and for a user's measure."""
    if arm.measure == "min-singular-value":
        return "" if arm.jacobian_rows == "rotation" else "m"
    return _UNIT[arm.jacobian_rows] if arm.measure in ("yoshikawa", "joint-limits") else ""


def full_jacobians(arm: Arm, q: Floats, frame: int | None = None) -> Floats:
    """Return the Jacobians (n, 6, dof) of a frame (the tool) at configurations (n, dof), in world axes.

    They are at the frame's origin, linear rows first (m/rad), then angular ones.
    """
    model, aligned, chain = arm.model, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED, Chain.from_arm(arm)
    data, matrices = model.createData(), np.zeros((len(q), 6, model.nv))
    frame = arm.tool_id if frame is None else frame
    for k, row in enumerate(chain.values(q)):
        # Pinocchio drops an axis where there is one joint
        matrices[k] = pin.computeFrameJacobian(model, data, row, frame, aligned).reshape(6, model.nv)
    return matrices @ chain.coupling if chain.follows else matrices


def jacobians(arm: Arm, q: Floats) -> Floats:
    """Return the rows (n, rows, dof) of the tool's Jacobians that ``arm.jacobian_rows`` names.

    ``q`` is (n, dof). Translation and pose manipulability rank configurations differently (rank correlation 0.6 to
    0.75), so the robot file or the objective chooses.
    """
    return full_jacobians(arm, q)[:, slice(*rows_of(arm))]


def manipulability(arm: Arm, q: Floats) -> Floats:
    """Return w (n,), or the arm's own measure, at configurations (n, dof): 0 at a singular one.

    The lengths that remain when the rows of J are orthogonalised one after the other multiply to w; the determinant in
    sqrt(det(J Jᵀ)) is negative by rounding in about half of all singular configurations. Modified Gram-Schmidt is as
    good as LAPACK's QR here (Björck 1967). Unit m^3 for six rows, m^3 for three, m^2 for two.
    """
    q = np.atleast_2d(np.asarray(q, dtype=float))
    if arm.measure != "yoshikawa":
        return evaluate_measure(arm, q)
    return Chain.from_arm(arm).native.manipulability(q, tools_and_rows(arm))


def node_manipulability(arm: Arm, q: Floats) -> Floats:
    """Return w (n,) at the nodes of a roadmap by Pinocchio's Jacobians: 10 us per configuration.

    :func:`manipulability` is our own compiled code, for the many states between nodes; the tests compare the two.
    """
    q = np.atleast_2d(np.asarray(q, dtype=float))
    if arm.measure != "yoshikawa":
        return evaluate_measure(arm, q)

    def volumes(one: Arm) -> Floats:
        rows = jacobians(one, q)
        return _volumes(rows if rows.shape[1] <= rows.shape[2] else rows.swapaxes(1, 2))

    return least_of_tools(arm, volumes)


def manipulability_along(arm: Arm, start: Floats, delta: Floats, shares: Floats) -> Floats:
    """Return w (n, k) along motions from ``start`` by ``delta`` (n, dof), at ``shares`` (k,) of them."""
    if arm.measure != "yoshikawa":
        states = start[:, None] + shares[:, None] * delta[:, None]
        return evaluate_measure(arm, states.reshape(-1, arm.dof)).reshape(states.shape[:2])
    return Chain.from_arm(arm).native.manipulability_along(start, delta, shares, tools_and_rows(arm))


def is_always_singular(arm: Arm) -> bool:
    """Return whether w is 0 in 16 random configurations, as where the tool's origin is on the last axis."""
    q = np.random.default_rng(0).uniform(arm.lower, arm.upper, size=(16, arm.dof))
    return bool(manipulability(arm, q).max() < _ALWAYS)


def evaluate_measure(arm: Arm, q: Floats) -> Floats:
    """Return the arm's measure (n,) that replaces w at configurations (n, dof).

    Raises :class:`OptionError` where it is negative.
    """
    if callable(arm.measure):
        values = numbers("manipulability", arm.measure(q), (len(q),))
        if (values < 0.0).any():
            raise OptionError(f"manipulability must be at least 0, got {values.min():g}: give another measure.")
        return values
    return least_of_tools(arm, lambda one: _singular_measure(one, q))


def least_of_tools(arm: Arm, measure: Callable[[Arm], Floats]) -> Floats:
    """Return the least ``measure`` (...) of any tool, evaluated for the arm with each tool alone."""
    return np.minimum.reduce([measure(one) for one in arm.with_each_tool])


def _singular_measure(arm: Arm, q: Floats) -> Floats:
    rows = jacobians(arm, q)
    if arm.measure == "joint-limits":
        mobile: Floats = rows * np.sqrt(_mobility(arm, q))[:, None]
        return np.linalg.svd(mobile, compute_uv=False).prod(axis=1)
    values = np.asarray(np.linalg.svd(rows, compute_uv=False), dtype=np.float64)
    if arm.measure == "min-singular-value":
        return values[:, -1]
    return np.divide(values[:, -1], values[:, 0], out=np.zeros(len(q)), where=values[:, 0] > 0.0)


def _mobility(arm: Arm, q: Floats) -> Floats:
    """Return (n, dof) 1 / (1 + |dH/dq|) (Chan and Dubey 1995): 1 in mid-range, 0 at the limits.

    H = sum (u - l)² / (4 (u - q)(q - l)) over the limits l and u of the joints; a continuous joint has none.
    """
    below, above = np.maximum(q - arm.lower, 0.0), np.maximum(arm.upper - q, 0.0)
    slope = (arm.upper - arm.lower) ** 2 * np.abs(below - above)
    scale = 4.0 * (below * above) ** 2
    return np.where(arm.continuous, 1.0, scale / (scale + slope))


def _volumes(rows: Floats) -> Floats:
    """Return (n,) the volumes that the rows of matrices (n, k, m) span, k <= m, by modified Gram-Schmidt."""
    rows, volumes = rows.copy(), np.ones(len(rows))
    for k in range(rows.shape[1]):
        lengths = np.sqrt(np.einsum("nm,nm->n", rows[:, k], rows[:, k]))
        volumes *= lengths
        unit = rows[:, k] / np.where(lengths > 0.0, lengths, 1.0)[:, None]
        rows[:, k + 1 :] -= np.einsum("nkm,nm->nk", rows[:, k + 1 :], unit)[:, :, None] * unit[:, None]
    return volumes


def tools_and_rows(arm: Arm) -> tuple[Ints, Floats, tuple[int, int]]:
    """Return the joints (k,) of the tools, positions (k, 3) in their frames, and :func:`rows_of` J."""
    joints, placements = zip(*map(tool_joint, arm.with_each_tool), strict=True)
    return np.array(joints), np.array([place.translation for place in placements]), rows_of(arm)
