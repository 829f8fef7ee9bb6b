"""Queries on graphs by cheapest paths."""

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.native.compiled import cheapest_costs, cheapest_path


def cheapest_nodes(nodes: int, arcs: Ints, cost: Floats, starts: Ints, goals: Ints) -> Ints:
    """Return the nodes (k,) of :func:`planner.native.compiled.cheapest_path`."""
    return cheapest_path(nodes, arcs, cost, starts, goals)[0]


def reachable(begin: Bools, arcs: Ints) -> Bools:
    """Return which nodes (n,) directed ``arcs`` (m, 2) connect from those in the mask ``begin`` (n,)."""
    starts = np.flatnonzero(begin)
    return np.isfinite(cheapest_costs(len(begin), arcs[:, ::-1], np.ones(len(arcs)), starts, np.zeros(len(starts))))
