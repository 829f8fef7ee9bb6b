"""What the compiled library finds in graphs: cheapest paths, what they cost, and detours. Arrays are in C order.

:class:`ArrayError` where arrays are not of the shapes that stand here, an index is no node, or a cost is negative.
"""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.native.loading import address, floats, ints, library, threads


def detours(nodes: int, edges: Ints, lengths: Floats, pairs: Ints, limits: Floats) -> Floats:
    """Lengths (k,) of the shortest paths between ``pairs`` (k, 2) in a graph of undirected ``edges`` (m, 2).

    inf where a path is longer than its limit (k,), or there is none.
    """
    m, k = len(edges), len(pairs)
    edges, lengths, pairs, limits = ints(edges, m, 2), floats(lengths, m), ints(pairs, k, 2), floats(limits, k)
    found = np.empty(k)
    graph = nodes, m, address(edges), address(lengths)
    library.graph_detours(*graph, k, address(pairs), address(limits), threads(), address(found))
    return found


def cheapest_path(nodes: int, arcs: Ints, cost: Floats, starts: Ints, goals: Ints) -> tuple[Ints, Ints]:
    """The cheapest path over ``arcs`` (m, 2), directed, from a start to a goal; no node where none is.

    Its nodes (k,), and the rows (k - 1,) of ``arcs`` that lead from one to the next.
    """
    m = len(arcs)
    arcs, cost, starts, goals = ints(arcs, m, 2), floats(cost, m), ints(starts, len(starts)), ints(goals, len(goals))
    path, used = np.empty((2, nodes), dtype=np.int64)
    graph = nodes, m, address(arcs), address(cost)
    ends = len(starts), address(starts), len(goals), address(goals)
    count = library.graph_cheapest(*graph, *ends, address(path), address(used))
    return path[:count], used[: max(0, count - 1)]


def cheapest_nodes(nodes: int, arcs: Ints, cost: Floats, starts: Ints, goals: Ints) -> Ints:
    """The nodes (k,) of :func:`cheapest_path`."""
    return cheapest_path(nodes, arcs, cost, starts, goals)[0]


def cheapest_costs(nodes: int, arcs: Ints, cost: Floats, goals: Ints, values: Floats) -> Floats:
    """The cost (n,) of the cheapest path from every node to a goal over ``arcs`` (m, 2), directed; inf without one.

    It ends with the goal's own of ``values`` (g,), which goals keep. ``cost`` (m,) is positive.
    """
    m, g = len(arcs), len(goals)
    arcs, cost, goals, values = ints(arcs, m, 2), floats(cost, m), ints(goals, g), floats(values, g)
    found = np.empty(nodes)
    graph = nodes, m, address(arcs), address(cost)
    library.graph_costs(*graph, g, address(goals), address(values), address(found))
    return found


def reached(begin: Bools, arcs: Ints) -> Bools:
    """(n,) which nodes a path over ``arcs`` (m, 2), directed, leads to from those where ``begin`` (n,) is True."""
    starts = np.flatnonzero(begin)
    return np.isfinite(cheapest_costs(len(begin), arcs[:, ::-1], np.ones(len(arcs)), starts, np.zeros(len(starts))))
