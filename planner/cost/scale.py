"""What turns manipulability and length into costs of comparable size."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from planner.base.arrays import Floats, frozen
from planner.base.errors import OptionError, choices
from planner.native.compiled import manipulability_cost_sums, manipulability_costs
from planner.problem.options import ManipulabilityCost, Metric
from planner.problem.request import DEFAULT_COST

CAP_QUANTILE = 0.05  # nodes below this quantile of w all cost 1
ZETA = 0.01  # the cheapest node, and the shortest edge, cost at least this: eq. (progressive) holds at every beta

COSTS: tuple[ManipulabilityCost, ...] = ("inverse", "log", "linear")


@dataclass(frozen=True)
class CostScale:
    """The scale factors of a roadmap, measured once; kept with it and reused as it grows.

    The manipulability cost is decreasing in w, capped below ``w_low`` (so that one near-singular node cannot stretch
    the scale), 1 there and ``zeta`` at ``w_high``. A length is divided by the longest one. ``zeta`` > 0 keeps the
    kernel progressive, eq. (progressive), at every beta.
    """

    w_low: float
    w_high: float
    joint_length: float
    """rad"""
    tool_length: float
    """m"""
    zeta: float


def length_cost(scale: CostScale, metric: Metric, joint: Floats, tool: Floats) -> Floats:
    """The normalised length (k,), at least zeta, of motions of ``joint`` (k,) rad and a path of ``tool`` (k,) metres.

    ``metric`` says which of the two counts.
    """
    length = joint / scale.joint_length if metric == "joint" else tool / scale.tool_length
    return np.maximum(length, scale.zeta)


def measure_scale(manipulability: Floats, joint_length: Floats, tool_length: Floats) -> CostScale:
    """The scale factors of a roadmap's first nodes: kept from then on, so that costs stay comparable as it grows.

    w is capped below its ``CAP_QUANTILE``; a length is measured in the longest edge.
    """
    low = float(np.quantile(manipulability, CAP_QUANTILE))
    high = float(manipulability.max())
    return CostScale(
        w_low=max(low, 1e-9 * high, 1e-300),
        w_high=max(high, 1e-300),
        joint_length=float(joint_length.max(initial=0.0)) or 1.0,
        tool_length=float(tool_length.max(initial=0.0)) or 1.0,
        zeta=ZETA,
    )


def manipulability_cost(w: Floats, scale: CostScale, name: ManipulabilityCost = DEFAULT_COST) -> Floats:
    """The cost omega of eq. (finew), in [zeta, 1], decreasing in w: 1 at and below ``scale.w_low``, zeta at ``w_high``.

    ``inverse`` 1/w punishes the neighbourhood of singularities most and tells good nodes apart least, ``linear`` -w
    the reverse, ``log`` -ln w stands between.
    """
    costs = manipulability_costs(w.ravel(), scale.w_low, scale.w_high, scale.zeta, cost_number(name))
    return costs.reshape(w.shape)


def mean_manipulability_cost(w: Floats, scale: CostScale, name: ManipulabilityCost = DEFAULT_COST) -> Floats:
    """The mean (m,) of omega along motions, by Simpson's rule over w (m, k) at evenly spaced states, k odd."""
    weights = _simpson_weights(w.shape[1])
    return manipulability_cost_sums(w, weights, scale.w_low, scale.w_high, scale.zeta, cost_number(name))


def cost_number(name: ManipulabilityCost) -> int:
    """The place of a cost in ``COSTS``; :class:`OptionError` for others."""
    if name not in COSTS:
        raise OptionError(f"manipulability cost '{name}' not found; costs are {choices(COSTS)}.")
    return COSTS.index(name)


@lru_cache
def _simpson_weights(count: int) -> Floats:
    """(count,) weights of Simpson's rule on [0, 1] for an odd number of evenly spaced points."""
    weights = np.where(np.arange(count) % 2 == 1, 4.0, 2.0)
    weights[[0, -1]] = 1.0
    return frozen(weights / weights.sum())
