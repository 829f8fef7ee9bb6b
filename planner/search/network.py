"""The network of eq. (finew) on a roadmap: normalised manipulability and distance, weighed by beta."""

from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, combine_costs
from planner.base.errors import AssumptionError, KeywordError, OptionError
from planner.cost.scale import cost_number, length_cost, manipulability_cost
from planner.native.graphs import cheapest_nodes
from planner.problem.options import Metric
from planner.problem.request import DEFAULT_METRIC, Objective
from planner.roadmap.roadmap import Roadmap

_PLAIN = Objective()


@dataclass(frozen=True)
class PathCost:
    """A path's cost as eq. (finew) sums it: total = (1 - beta) manipulability + beta distance."""

    total: float
    manipulability: float
    distance: float
    beta: float


def distance_cost(roadmap: Roadmap, metric: Metric = DEFAULT_METRIC) -> Floats:
    """Return the normalised length w_ij of every edge (m,), at least zeta.

    ``joint`` is the Euclidean joint motion, ``workspace`` the length of the tool's path.
    """
    return length_cost(roadmap.scale, metric, roadmap.joint_length, roadmap.tool_length)


def build_network(
    roadmap: Roadmap,
    objective: Objective | float | None = None,
    clearance: float = 0.0,
    *,
    beta: float | None = None,
) -> gabf.Network:
    """Return the network of a roadmap: two arcs per edge, the goals as sources, the kernel of eq. (finew).

    ``objective`` may be ``beta`` alone, by either name: larger values weigh distance more and manipulability less. With
    its ``charge`` "nodes" omega is that of the node that an edge leads to, as in the paper; with "edges" it is
    integrated along the edge over its length, over states ``W_IN_COST`` apart, so that the cost of a path does not
    depend on the number of its nodes. Edges that are not certified to have ``clearance`` (m) beyond the margin are left
    out.
    """
    if objective is not None and beta is not None:
        raise KeywordError("beta is a field of the objective: give it there, or leave the objective out.")
    if not clearance >= 0.0:
        raise OptionError(f"clearance must be at least 0 m, got {clearance:g}.")
    given = beta if objective is None else objective
    objective = given if isinstance(given, Objective) else _PLAIN if given is None else Objective(given)
    name, beta = objective.manipulability_cost, objective.beta
    used = roadmap.clearance >= clearance
    weight = np.tile(distance_cost(roadmap, objective.metric)[used], 2)
    along = objective.cost_integration == "edges"
    omega = roadmap.edge_cost[used, cost_number(name)] if along else None
    return gabf.Network.from_arcs(
        tails=roadmap.edges[used].T.ravel(),
        heads=roadmap.edges[used, ::-1].T.ravel(),
        weight=weight,
        sources=roadmap.goals,
        n_nodes=len(roadmap.nodes),
        node_cost=manipulability_cost(roadmap.manipulability, roadmap.scale, name),
        arc_cost=None if omega is None else np.tile(omega, 2) * weight,
        kernel=gabf.EdgeIntegral(beta=beta) if along else gabf.TradeOff(beta=beta),
    )


def at_beta(network: gabf.Network, beta: float) -> gabf.Network:
    """Return the network at another beta, for both kernels of eq. (finew)."""
    return replace(network, kernel=_kernel_at(network, beta))


def _kernel_at(network: gabf.Network, beta: float) -> gabf.Kernel:
    if not isinstance(network.kernel, gabf.TradeOff | gabf.EdgeIntegral):
        raise AssumptionError(f"the kernel must be TradeOff or EdgeIntegral, got {type(network.kernel).__name__}.")
    return replace(network.kernel, beta=beta)


def arc_costs(network: gabf.Network) -> Floats:
    """Return (n_arcs, 2) the Omega and D of each arc: its cost at beta 0 and at beta 1."""
    nothing, kernels = np.zeros(network.n_arcs), [_kernel_at(network, beta) for beta in (0.0, 1.0)]
    bound = [kernel.bind(network) for kernel in kernels]  # pyright: ignore[reportArgumentType]  (as for Network.arcs)
    return np.column_stack([arcs(nothing) for arcs in bound])


def path_cost(network: gabf.Network, nodes: Ints) -> PathCost:
    """Return the cost of nodes (k,), start first, on a network of :func:`build_network`.

    No arcs run parallel there.
    """
    steps = arc_costs(network)[network.arcs_along(nodes)]
    manipulability, distance = (float(total) for total in steps.sum(axis=0))
    beta: float = network.kernel.beta  # type: ignore[attr-defined]  (arc_costs refused any other kernel)
    return PathCost(combine_costs(beta, manipulability, distance), manipulability, distance, beta)


def edge_rows(roadmap: Roadmap, tails: Ints, heads: Ints) -> Ints:
    """Return the rows (k,) of the edges between ``tails`` and ``heads`` (k,), in either direction."""
    n, edges = len(roadmap.nodes), roadmap.edges
    low, high = np.minimum(tails, heads), np.maximum(tails, heads)
    return np.searchsorted(edges[:, 0] * n + edges[:, 1], low * n + high)


def cheapest_steps(network: gabf.Network, starts: Ints) -> Ints:
    """Return the nodes (k,) of the cheapest path from ``starts`` to a source, (0,) without a way."""
    arcs = np.column_stack([network.tails, network.indices])
    return cheapest_nodes(network.n_nodes, arcs, network.arcs(np.zeros(network.n_arcs)), starts, network.sources)
