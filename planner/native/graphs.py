"""What the compiled library finds in graphs: cheapest paths, what they cost, and detours. Arrays are in C order."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.native.loading import address, floats, ints, library, threads


def detours(nodes: int, edges: Ints, lengths: Floats, pairs: Ints, limits: Floats) -> Floats:
    """Lengths (k,) of the shortest paths between ``pairs`` (k, 2) in a graph of undirected ``edges`` (m, 2).

    inf where a path is longer than its limit (k,), or there is none.
    """
    edges, lengths, pairs, limits = ints(edges), floats(lengths), ints(pairs), floats(limits)
    found = np.empty(len(pairs))
    graph = nodes, len(edges), address(edges), address(lengths)
    library.graph_detours(*graph, len(pairs), address(pairs), address(limits), threads(), address(found))
    return found


def cheapest_nodes(nodes: int, arcs: Ints, cost: Floats, starts: Ints, goals: Ints) -> Ints:
    """The nodes (k,) of the cheapest path over ``arcs`` (m, 2), directed, from a start to a goal; (0,) without one."""
    arcs, cost, starts, goals = ints(arcs), floats(cost), ints(starts), ints(goals)
    path = np.empty(nodes, dtype=np.int64)
    graph = nodes, len(arcs), address(arcs), address(cost)
    ends = len(starts), address(starts), len(goals), address(goals)
    return path[: library.graph_cheapest(*graph, *ends, address(path))]


def cheapest_costs(nodes: int, arcs: Ints, cost: Floats, goals: Ints, values: Floats) -> Floats:
    """The cost (n,) of the cheapest path from every node to a goal over ``arcs`` (m, 2), directed; inf without one.

    It ends with the goal's own of ``values`` (g,), which goals keep. ``cost`` (m,) is positive.
    """
    arcs, cost, goals, values = ints(arcs), floats(cost), ints(goals), floats(values)
    found = np.empty(nodes)
    graph = nodes, len(arcs), address(arcs), address(cost)
    library.graph_costs(*graph, len(goals), address(goals), address(values), address(found))
    return found
