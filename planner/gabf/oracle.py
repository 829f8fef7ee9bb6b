"""Algorithms that never integrate, to check the dynamics by: they find x* of eq. (bellman) from the kernel alone."""

from __future__ import annotations

import heapq

import numpy as np

from planner.base.arrays import Floats, plain_numbers
from planner.base.errors import AssumptionError
from planner.gabf.arcmaps import AffineArcs
from planner.gabf.network import Network
from planner.gabf.problem import Problem, field, reduce
from planner.gabf.result import CostToGo
from planner.native.compiled import cheapest_costs


def oracle(net: Network) -> Floats:
    """x* (n,) by generalized Dijkstra with a heap, for any increasing progressive kernel; +inf where unreachable.

    Nodes leave the heap in ascending order of x*, as the levels S_l of eq. (S). An arc that lowers a value
    below that of the node it came from breaks the order, and raises AssumptionError. Where the kernel adds positive
    costs a compiled search finds the same, to the bit.
    """
    arcs = net.arcs
    if isinstance(arcs, AffineArcs) and arcs.slope is None and (arcs.offset > 0).all():
        ends = np.column_stack([net.tails, net.indices])
        assert net.source_values is not None
        return cheapest_costs(net.n_nodes, ends, arcs.offset, net.sources, net.source_values)
    problem = reduce(net)
    return problem.unpack(_dijkstra(problem))


def _dijkstra(problem: Problem) -> Floats:
    best = [np.inf] * problem.n_rows + problem.anchors.tolist()
    indptr, order = problem.readers.indptr.tolist(), problem.readers.order
    owners = problem.owners[order].tolist()
    reach = _affine_reach(problem, indptr, order) if isinstance(problem.arcs, AffineArcs) else None
    heap = [(value, node) for node, value in enumerate(best) if node >= problem.n_rows]
    heapq.heapify(heap)
    while heap:
        value, j = heapq.heappop(heap)
        if value > best[j]:
            continue
        arcs = slice(indptr[j], indptr[j + 1])
        reached = reach(value, arcs) if reach else _values(problem, order[arcs], value)
        for i, offer in zip(owners[arcs], reached, strict=True):
            if offer < best[i]:
                if offer < value:
                    _refuse(problem, i, j)
                best[i] = offer
                heapq.heappush(heap, (offer, i))
    return np.array(best)


def _affine_reach(problem: Problem, indptr: list[int], order: np.ndarray):
    arcs = problem.arcs.take(order)
    assert isinstance(arcs, AffineArcs)
    offset = arcs.offset.tolist()
    if arcs.slope is None:
        return lambda value, span: [value + c for c in offset[span]]
    slope = arcs.slope.tolist()
    return lambda value, span: [s * value + c for s, c in zip(slope[span], offset[span], strict=True)]


def _values(problem: Problem, arcs: np.ndarray, value: float) -> list[float]:
    return problem.arcs.take(arcs)(np.full(arcs.size, value)).tolist() if arcs.size else []


def _refuse(problem: Problem, i: int, j: int) -> None:
    raise AssumptionError(
        f"node {problem.nodes[i]} would cost less than node {problem.nodes[j]} that it reads: the kernel is "
        "not progressive, eq. (progressive), so no order of nodes finds x*; raise the arc's cost"
    )


def bellman_operator(net: Network, x: Floats) -> Floats:
    """T'x (n,) of eq. (bellman-gabf): sources keep their values, others take min_j f_i(x_j, w_ij).

    It is +inf at unreachable nodes.
    """
    problem = reduce(net)
    return problem.unpack(problem.swept(problem.pack(field(problem, x, "x"))))


def value_iteration(net: Network, x0: Floats, max_sweeps: int | None = None) -> tuple[Floats, int]:
    """Iterate T' of eq. (bellman-gabf), remark (SSP), until nothing changes: the discrete algorithm.

    Returns x and the number of sweeps that changed it. From overestimates n sweeps suffice; from below the
    number grows like x* / zeta. AssumptionError if ``max_sweeps`` (default 1000 n) do not suffice.
    """
    problem = reduce(net)
    budget = 1000 * net.n_nodes if max_sweeps is None else max_sweeps
    settled = problem.settled(problem.pack(field(problem, x0, "x0")), budget)
    if settled is None:
        raise AssumptionError(f"value iteration still moves after {budget} sweeps: start from overestimate(net)")
    return problem.unpack(settled[0]), settled[1]


def residual(net: Network, x: Floats) -> float:
    """max_i |x_i - min_j f_i(x_j, w_ij)| over reachable nodes: small is not converged, see settling.error_bound."""
    problem = reduce(net)
    y = problem.pack(field(problem, x, "x"))
    return float(np.abs(problem.disequilibrium(y)).max(initial=0.0))


def max_error(result: CostToGo | Floats, x_star: Floats) -> float:
    """max |x_i - x_i*| / max(1, |x_i*|) over nodes that reach a source; +inf if x and x* disagree on which do."""
    x = result.x if isinstance(result, CostToGo) else plain_numbers("x", result, AssumptionError)
    x_star = plain_numbers("x_star", x_star, AssumptionError)
    finite = np.isfinite(x_star)
    if not np.array_equal(finite, np.isfinite(x)):
        return float("inf")
    error = np.abs(x[finite] - x_star[finite]) / np.maximum(1.0, np.abs(x_star[finite]))
    return float(error.max(initial=0.0))
