"""From a roadmap to the network of eq. (finew): manipulability and distance, normalised, traded off by beta."""

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
    """The normalised length w_ij of every edge (m,), at least zeta.

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
    """The network whose cost-to-go GABF computes: two arcs per edge, the goals as sources, the kernel of eq. (finew).

    ``objective`` may be ``beta`` alone, by either name: larger values weigh distance more and manipulability less. With
    its ``cost_integration`` "nodes" omega is that of the node that an edge leads to, as in the paper; with "edges" it
    is integrated along the edge over its length, over states ``W_IN_COST`` apart, so that the cost of a path does not
    depend on how many nodes lie on it. Edges that are not certified to keep ``clearance`` (m) beyond the margin are
    left out.
    """
    if objective is not None and beta is not None:
        raise KeywordError("beta is a part of the objective: give it there, or leave the objective out.")
    if not clearance >= 0.0:
        raise OptionError(f"clearance {clearance:g} m is not usable: give a distance of 0 or more.")
    given = beta if objective is None else objective
    objective = given if isinstance(given, Objective) else _PLAIN if given is None else Objective(given)
    name, beta = objective.manipulability_cost, objective.beta
    kept = roadmap.clearance >= clearance
    weight = np.tile(distance_cost(roadmap, objective.metric)[kept], 2)
    along = objective.cost_integration == "edges"
    omega = roadmap.edge_cost[kept, cost_number(name)] if along else None
    return gabf.Network.from_arcs(
        tails=roadmap.edges[kept].T.ravel(),
        heads=roadmap.edges[kept, ::-1].T.ravel(),
        weight=weight,
        sources=roadmap.goals,
        n_nodes=len(roadmap.nodes),
        node_cost=manipulability_cost(roadmap.manipulability, roadmap.scale, name),
        arc_cost=None if omega is None else np.tile(omega, 2) * weight,
        kernel=gabf.EdgeIntegral(beta=beta) if along else gabf.TradeOff(beta=beta),
    )


def at_beta(network: gabf.Network, beta: float) -> gabf.Network:
    """The same network at another beta, whatever its kernel charges omega to."""
    return replace(network, kernel=_kernel_at(network, beta))


def _kernel_at(network: gabf.Network, beta: float) -> gabf.Kernel:
    if not isinstance(network.kernel, gabf.TradeOff | gabf.EdgeIntegral):
        raise AssumptionError(f"{type(network.kernel).__name__} has no beta: take TradeOff or EdgeIntegral.")
    return replace(network.kernel, beta=beta)


def arc_costs(network: gabf.Network) -> Floats:
    """(n_arcs, 2) what an arc adds to a path's Omega and D: the cost at beta 0 and at beta 1, for any kernel."""
    nothing, kernels = np.zeros(network.n_arcs), [_kernel_at(network, beta) for beta in (0.0, 1.0)]
    bound = [kernel.bind(network) for kernel in kernels]  # pyright: ignore[reportArgumentType]  (as for Network.arcs)
    return np.column_stack([arcs(nothing) for arcs in bound])


def path_cost(network: gabf.Network, nodes: Ints) -> PathCost:
    """The cost of a node sequence, start first, on a network of :func:`build_network`; no arcs run parallel there."""
    steps = arc_costs(network)[network.arcs_along(nodes)]
    manipulability, distance = (float(total) for total in steps.sum(axis=0))
    beta: float = network.kernel.beta  # type: ignore[attr-defined]  (arc_costs refused any other kernel)
    return PathCost(combine_costs(beta, manipulability, distance), manipulability, distance, beta)


def edge_rows(roadmap: Roadmap, tails: Ints, heads: Ints) -> Ints:
    """The rows (k,) of the roadmap's edges between ``tails`` and ``heads`` (k,), in either direction."""
    n, edges = len(roadmap.nodes), roadmap.edges
    low, high = np.minimum(tails, heads), np.maximum(tails, heads)
    return np.searchsorted(edges[:, 0] * n + edges[:, 1], low * n + high)


def cheapest_steps(network: gabf.Network, starts: Ints) -> Ints:
    """The nodes (k,) of the cheapest path from ``starts`` to a source, by Dijkstra's algorithm; none without one."""
    arcs = np.column_stack([network.tails, network.indices])
    return cheapest_nodes(network.n_nodes, arcs, network.arcs(np.zeros(network.n_arcs)), starts, network.sources)
