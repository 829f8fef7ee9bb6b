"""The path of a settled field: from a node along minimising neighbours to a source."""

from collections.abc import Sequence

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, indices
from planner.base.errors import ArrayError, StateError
from planner.gabf.network import Network
from planner.gabf.problem import Problem, check_finite_states, check_states, reduce_network
from planner.gabf.solve import CostToGo

SLACK = 1e-9  # times max(1, |x|): arcs so close to the minimum are ties if the field is not settled to the bit


def extract_path(net: Network, result: CostToGo | Floats, start: int) -> Ints:
    """Return the nodes from ``start`` to a source along minimising neighbours.

    Ties go to the fewest hops, then to the smallest index. Hops count minimising arcs and each step goes one hop down,
    so no node repeats, even where two states round to the same number. Raises StateError if ``start`` is not a node,
    reaches no source, or the field has not settled; AssumptionError if the field does not belong to this network.
    """
    return _extract_paths(net, result, [start])[0]


def paths_from(network: Network, cost_to_go: CostToGo | Floats, starts: Ints | Sequence[int]) -> tuple[Ints, ...]:
    """Return the cheapest node path (k,) from each of ``starts`` (s,) to a goal; empty without a way.

    x at a start is the cost of its path. :func:`planner.roadmap.roadmap.path_waypoints` turns nodes into
    configurations:

        roadmap = attach(load_roadmap(file), checker, starts, goals)      # nodes for all of them, linked by proofs
        network = planner.build_network(roadmap, 0.5)
        paths = paths_from(network, planner.gabf.solve(network, law), roadmap.starts)

    Raises :class:`StateError` for a start that is no node.
    """
    x = check_states(network, cost_to_go, "x")
    nodes = indices("starts", starts, ("s",), network.n_nodes, StateError)
    reaching = nodes[np.isfinite(x[nodes])].tolist()
    paths = dict(zip(reaching, _extract_paths(network, cost_to_go, reaching), strict=True))
    return tuple(paths.get(start, np.zeros(0, dtype=np.int64)) for start in nodes.tolist())


def cheapest_path(result: CostToGo, starts: Ints) -> Ints:
    """Return the path from the one of ``starts`` (s,) with the least cost-to-go; (0,) without a way."""
    starts = indices("starts", starts, ("s",), result.network.n_nodes)
    if not len(starts):
        raise ArrayError("starts must not be empty: give the index of at least one node.")
    start = int(starts[np.argmin(result.x[starts])])
    return paths_from(result.network, result, [start])[0]


def _extract_paths(net: Network, result: CostToGo | Floats, starts: Sequence[int]) -> list[Ints]:
    problem = result.problem if isinstance(result, CostToGo) and result.network is net else reduce_network(net)
    position = np.full(net.n_nodes, -1)
    position[problem.nodes] = np.arange(problem.nodes.size)
    for start in starts:
        if start not in range(net.n_nodes):
            raise StateError(f"start must be a node from 0 to {net.n_nodes - 1}, got {start}.")
        if position[start] < 0:
            raise StateError(f"node {start} reaches no source: connect it, or start from another node.")
    y = problem.pack(check_finite_states(problem, result, "x"))
    values = problem.arcs(y[problem.heads])
    least = np.minimum.reduceat(values, problem.starts) if problem.n_rows else np.empty(0)
    settled = np.array_equal(least, y[: problem.n_rows])
    slack = 0.0 if settled else SLACK * np.maximum(1.0, np.abs(least))
    tight = values <= (least + slack)[problem.owners]
    hops = problem.hops_along(tight)
    for start in starts:
        if hops[position[start]] < 0:
            cause = f"minimising neighbours of node {start} lead to no source"
            raise StateError(f"{cause}, as the field has not settled: solve it to the end.")
    return [problem.nodes[_descend(problem, tight, hops, int(position[start]))] for start in starts]


def _descend(problem: Problem, tight: Bools, hops: Ints, here: int) -> list[int]:
    ends, path = np.append(problem.starts, problem.heads.size), [here]
    while here < problem.n_rows:
        arcs = slice(ends[here], ends[here + 1])
        heads = problem.heads[arcs][tight[arcs]]
        heads = heads[hops[heads] == hops[here] - 1]
        here = int(heads[np.argmin(problem.nodes[heads])])
        path.append(here)
    return path
