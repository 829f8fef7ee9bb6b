"""Many starts on one roadmap: the field that answered one of them answers all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, numbers, plain_numbers
from planner.base.errors import AssumptionError, StateError
from planner.base.kinds import checks_kinds
from planner.gabf.path import extract_paths


@checks_kinds
def paths_from(
    network: gabf.Network, cost_to_go: gabf.CostToGo | Floats, starts: Ints | Sequence[int]
) -> tuple[Ints, ...]:
    """The cheapest node path (k,) from each of the ``starts`` (s,) to a goal; empty where no goal can be reached.

    Nothing is solved again: along minimising neighbours x already holds every node's cost-to-go, and x at a start is
    what its path costs. :func:`planner.roadmap.roadmap.path_waypoints` turns nodes into configurations:

        roadmap = attach(load_roadmap(file), checker, starts, goals)      # nodes for all of them, linked by proofs
        network = planner.build_network(roadmap, 0.5)
        paths = paths_from(network, gabf.solve(network, law), roadmap.starts)

    Raises :class:`StateError` for a start that is no node.
    """
    n = network.n_nodes
    x = cost_to_go.x if isinstance(cost_to_go, gabf.CostToGo) else plain_numbers("x", cost_to_go, AssumptionError)
    if x.shape != (n,):
        raise AssumptionError(f"x has shape {x.shape} where ({n},) is needed: one state a node")
    nodes = numbers("starts", starts, ("s",), StateError).tolist()
    nodes = [int(start) if start == int(start) else start for start in nodes]
    reaching = [start for start in nodes if start not in range(n) or np.isfinite(x[start])]
    paths = dict(zip(reaching, extract_paths(network, cost_to_go, reaching), strict=True))
    return tuple(paths.get(start, np.zeros(0, dtype=np.int64)) for start in nodes)
