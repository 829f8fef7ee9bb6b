"""Which nodes reach a source, and in how many hops: assumption (main), checked before any dynamics runs."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Ints
from planner.gabf.network import Network


def hops_to_source(net: Network) -> Ints:
    """(n,) fewest arcs from each node to a source, -1 where there is no path: breadth first, against arcs."""
    hops = np.full(net.n_nodes, -1, dtype=np.int64)
    frontier, level = net.sources, 0
    arcs_of = arcs_reading if net.n_arcs >= SWEEP_BELOW else _sweep
    while frontier.size:
        hops[frontier] = level
        found = net.tails[arcs_of(net, frontier)]
        frontier, level = distinct(found[hops[found] < 0], net.n_nodes), level + 1
    return hops


SWEEP_BELOW = 20_000
"""Arcs below which looking at all of them at each level is faster than reversing the graph."""


def _sweep(net: Network, nodes: Ints) -> Ints:
    """The same as :func:`arcs_reading`, from a look at every arc."""
    chosen = np.zeros(net.n_nodes, dtype=bool)
    chosen[nodes] = True
    return np.flatnonzero(chosen[net.indices])


def arcs_reading(net: Network, nodes: Ints) -> Ints:
    """Ids of every arc that reads one of ``nodes``."""
    indptr, order = net.readers
    return order[ranges(indptr[nodes], indptr[nodes + 1] - indptr[nodes])]


def ranges(starts: Ints, counts: Ints) -> Ints:
    """starts[k], starts[k] + 1, ... counts[k] of them, for every k in turn."""
    ends = np.cumsum(counts)
    return np.repeat(starts - (ends - counts), counts) + np.arange(counts.sum())


def distinct(nodes: Ints, n_nodes: int) -> Ints:
    """The distinct entries, ascending."""
    if nodes.size * 500 < n_nodes:
        return np.unique(nodes)
    seen = np.zeros(n_nodes, dtype=bool)
    seen[nodes] = True
    return np.flatnonzero(seen)
