"""The optimum without an ODE: x* of eq. (bellman), and its parents, levels and diameter."""

import heapq
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, cumulative_sums, indices, plain_numbers
from planner.base.errors import AssumptionError
from planner.gabf.kernels import AffineArcs
from planner.gabf.network import Network
from planner.gabf.problem import Problem, check_finite_states, check_states, reduce_network
from planner.native.compiled import cheapest_costs


def oracle(net: Network) -> Floats:
    """Return x* (n,) by generalized Dijkstra, for any increasing progressive kernel; +inf if unreachable.

    Nodes leave the heap in ascending order of x*, as the levels S_l of eq. (S). An arc that lowers a value below that
    of its parent breaks the order and raises AssumptionError. Where the kernel adds positive costs a compiled search
    finds the same, to the bit.
    """
    arcs = net.arcs
    if isinstance(arcs, AffineArcs) and arcs.slope is None and (arcs.offset > 0).all():
        ends = np.column_stack([net.tails, net.indices])
        return cheapest_costs(net.n_nodes, ends, arcs.offset, net.sources, net.source_values)
    problem = reduce_network(net)
    return problem.unpack(_dijkstra(problem))


def _dijkstra(problem: Problem) -> Floats:
    order = np.argsort(problem.heads, kind="stable")  # node j is read by the arcs order[indptr[j] : indptr[j + 1]]
    indptr = cumulative_sums(np.bincount(problem.heads, minlength=problem.nodes.size))
    best = problem.with_sources(np.full(problem.n_rows, np.inf))
    heap = [(value, node) for node, value in enumerate(best.tolist()) if node >= problem.n_rows]
    heapq.heapify(heap)
    while heap:
        value, j = heapq.heappop(heap)
        arcs = order[indptr[j] : indptr[j + 1]]
        if value > best[j] or not arcs.size:
            continue
        offers = problem.arcs.take(arcs)(np.full(arcs.size, value))
        for i, offer in zip(problem.owners[arcs].tolist(), offers.tolist(), strict=True):
            if offer < best[i]:
                if offer < value:
                    nodes = f"node {problem.nodes[i]} would cost less than node {problem.nodes[j]} that it reads"
                    raise AssumptionError(f"{nodes}: the kernel is not progressive, so raise the arc's cost.")
                best[i] = offer
                heapq.heappush(heap, (offer, i))
    return best


def bellman_operator(net: Network, x: Floats) -> Floats:
    """Return T'x (n,) of eq. (bellman-gabf): min_j f_i(x_j, w_ij), or +inf; sources keep their values."""
    problem = reduce_network(net)
    return problem.unpack(
        problem.with_sources(problem.parent_values(problem.pack(check_finite_states(problem, x, "x"))))
    )


def value_iteration(net: Network, x0: Floats, max_sweeps: int | None = None) -> tuple[Floats, int]:
    """Return x and the number of sweeps that changed it, by T' of eq. (bellman-gabf), remark (SSP).

    From overestimates n sweeps suffice; from below the number grows like x* / zeta. AssumptionError if ``max_sweeps``
    (default 1000 n) do not suffice.
    """
    problem = reduce_network(net)
    y = problem.pack(check_finite_states(problem, x0, "x0"))
    budget = 1000 * net.n_nodes if max_sweeps is None else max_sweeps
    for sweep in range(budget + 1):
        swept = problem.with_sources(problem.parent_values(y))
        if np.array_equal(swept, y):
            return problem.unpack(y), sweep
        y = swept
    raise AssumptionError(f"value iteration still moves after {budget} sweeps: start from overestimate(net).")


def max_error(result: Any, x_star: Floats) -> float:
    """Return max |x_i - x_i*| / max(1, |x_i*|) over nodes that reach a source.

    ``result`` is x (n,) or a :class:`planner.gabf.CostToGo`. +inf if x and x* disagree on which nodes reach a source.
    """
    x = plain_numbers("x", getattr(result, "x", result), AssumptionError)
    x_star = plain_numbers("x_star", x_star, AssumptionError)
    if not np.array_equal(finite := np.isfinite(x_star), np.isfinite(x)):
        return np.inf
    error = np.abs(x[finite] - x_star[finite]) / np.maximum(1.0, np.abs(x_star[finite]))
    return float(error.max(initial=0.0))


TIES = 1e-12  # times max(1, |x*|), 1 less where all x* are: smaller differences of costs are ties, as costs round


@dataclass(frozen=True, eq=False)
class Structure:
    """Definitions (true), (longest) and (S) as arrays over n nodes, -1 for nodes that reach no source.

    ``x_star`` (n,); ``true_arcs`` ids of the arcs (i, j) with j in P(i); ``longest`` the l of F_l; ``fewest`` arcs on
    the optimal path of fewest hops (ours); ``level`` the l of S_l; ``values`` (R + 1,) the distinct xbar_l*, the
    sources' smallest value first; ``diameter`` D(G) in nodes, so that 6 -> 8 -> 9 counts three.
    """

    x_star: Floats
    true_arcs: Ints
    longest: Ints
    fewest: Ints
    level: Ints
    values: Floats
    diameter: int
    unreachable: Ints

    @property
    def R(self) -> int:
        """The number of levels, R of definition (S)."""
        return self.values.size - 1


def structure(net: Network, x_star: Floats | None = None) -> Structure:
    """Return the structure of the optimum of any progressive increasing kernel.

    ``x_star`` is the oracle's by default. Parents and hops count costs as tied that differ by at most 1e-12 max(1,
    |x*|), with the largest |x*| in place of 1 where that is less. Levels count every distinct x*: a chain of tiny arcs
    settles one after another.
    """
    x = oracle(net) if x_star is None else check_states(net, x_star, "x_star")
    problem = reduce_network(net)
    y = problem.pack(x)
    values, own, head = problem.arcs(y[problem.heads]), y[problem.owners], y[problem.heads]
    nearly = TIES * np.maximum(min(1.0, float(np.abs(y).max(initial=0.0))), np.abs(own))
    tight = (values <= own + nearly) & (head < own)  # smaller x*, so that no cycle of ties counts
    longest, fewest = _most_hops(problem, tight, y), problem.hops_along(tight)
    values, rank = np.unique(y[: problem.n_rows], return_inverse=True)
    level = problem.unpack(np.concatenate((rank + 1, np.zeros(problem.anchors.size, dtype=np.int64))), missing=-1)
    return Structure(
        x_star=x,
        true_arcs=problem.arc_ids[tight],
        longest=problem.unpack(longest, missing=-1),
        fewest=problem.unpack(np.where(fewest < 0, problem.nodes.size, fewest), missing=-1),
        level=level,
        values=np.concatenate(([problem.anchors.min()], values)),
        diameter=int(longest.max(initial=0)) + 1,
        unreachable=np.flatnonzero(level < 0),
    )


def true_parents(net: Network, optimum: Structure, i: int) -> Ints:
    """Return P(i), definition (true), ascending; empty at sources and nodes that reach none.

    Raises ArrayError if there is no node i.
    """
    i = int(indices("i", i, (), net.n_nodes))
    arcs = optimum.true_arcs
    return np.unique(net.indices[arcs[net.tails[arcs] == i]])


def _most_hops(problem: Problem, tight: Bools, y: Floats) -> Ints:
    """Return the most true arcs from each node to a source, in one pass, as they lead to smaller x*."""
    owners, heads = problem.owners[tight], problem.heads[tight]
    order = np.argsort(y[owners], kind="stable")
    hops = [0] * problem.nodes.size
    for owner, head in zip(owners[order].tolist(), heads[order].tolist(), strict=True):
        hops[owner] = max(hops[owner], hops[head] + 1)
    return np.array(hops, dtype=np.int64)
