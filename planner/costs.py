"""From a roadmap to the network of eq. (finew): manipulability and distance, normalised, traded off by beta."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import get_args

import numpy as np

from planner import gabf
from planner.arrays import Floats, Ints
from planner.errors import OptionError, choices
from planner.request import DEFAULT_COST, DEFAULT_METRIC, ManipulabilityCost, Metric, require_share
from planner.roadmap.roadmap import CostScale, Roadmap

METRICS: tuple[str, ...] = get_args(Metric)
CAP_QUANTILE = 0.05  # nodes below this quantile of w all cost 1
ZETA = 0.01  # the cheapest node, and the shortest edge, cost at least this: eq. (progressive) holds at every beta


@dataclass(frozen=True)
class PathCost:
    """A path's cost as eq. (finew) sums it: total = (1 - beta) manipulability + beta distance."""

    total: float
    manipulability: float
    distance: float
    beta: float


_DECREASING: dict[str, Callable[[Floats], Floats]] = {
    "inverse": lambda w: 1.0 / w,
    "log": lambda w: -np.log(w),
    "linear": lambda w: -w,
}
COSTS = tuple(_DECREASING)


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
    if name not in _DECREASING:
        raise OptionError(f"manipulability cost '{name}' not found; costs are {choices(COSTS)}.")
    decreasing = _DECREASING[name]
    best, worst = decreasing(np.array([scale.w_high, scale.w_low]))
    share = (decreasing(np.clip(w, scale.w_low, scale.w_high)) - best) / (worst - best) if worst > best else 0.0 * w
    return scale.zeta + (1.0 - scale.zeta) * np.clip(share, 0.0, 1.0)


def distance_cost(roadmap: Roadmap, metric: Metric = DEFAULT_METRIC) -> Floats:
    """The normalised length w_ij of every edge (m,), at least zeta.

    ``joint`` is the Euclidean joint motion, ``workspace`` the length of the tool's way.
    """
    if metric not in METRICS:
        raise OptionError(f"metric '{metric}' not found; metrics are {choices(METRICS)}.")
    joint = metric == "joint"
    length = roadmap.joint_length if joint else roadmap.tool_length
    unit = roadmap.scale.joint_length if joint else roadmap.scale.tool_length
    return np.maximum(length / unit, roadmap.scale.zeta)


def build_network(
    roadmap: Roadmap,
    beta: float = 0.5,
    manipulability: ManipulabilityCost = DEFAULT_COST,
    metric: Metric = DEFAULT_METRIC,
) -> gabf.Network:
    """The network whose cost-to-go GABF computes: two arcs an edge, the goals as sources, the kernel of eq. (finew).

    ``beta`` in [0, 1]: larger values weigh distance more and manipulability less.
    """
    require_share(beta)
    n = len(roadmap.nodes)
    reader = np.concatenate([roadmap.edges[:, 0], roadmap.edges[:, 1]])
    read = np.concatenate([roadmap.edges[:, 1], roadmap.edges[:, 0]])
    weight = np.tile(distance_cost(roadmap, metric), 2)
    order = np.lexsort((read, reader))
    return gabf.Network(
        indptr=np.concatenate([[0], np.cumsum(np.bincount(reader, minlength=n))]),
        indices=read[order],
        weight=weight[order],
        sources=roadmap.goals,
        node_cost=manipulability_cost(roadmap.manipulability, roadmap.scale, manipulability),
        kernel=gabf.TradeOff(beta=beta),
    )


def path_cost(network: gabf.Network, nodes: Ints) -> PathCost:
    """The cost of a node sequence, start first, on a network of :func:`build_network`, parallel arcs excluded."""
    kernel, omega = network.kernel, network.node_cost
    assert isinstance(kernel, gabf.TradeOff)
    assert omega is not None
    arcs = np.array([network.arcs_between(i, j)[0] for i, j in itertools.pairwise(nodes)], dtype=np.int64)
    manipulability, distance = float(omega[network.indices[arcs]].sum()), float(network.weight[arcs].sum())
    total = (1.0 - kernel.beta) * manipulability + kernel.beta * distance
    return PathCost(total, manipulability, distance, kernel.beta)
