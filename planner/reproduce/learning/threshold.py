"""The smallest K from which on the path of eq. (wb) is the Euclidean shortest one, graph by graph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planner import learning
from planner.base.arrays import Floats
from planner.reproduce.learning.graphs import GridGraph, dijkstra_path

PRECISION = 1e-3
"""The threshold is known to fail just below, and certified from (1 + PRECISION) times it on."""

_ABOVE = 1.0 + 1e-9  # the kernel needs K strictly above the longest weight
_NARROWEST = 1e-9  # relative width at which an interval that cannot be certified counts as a crossing
_PROBES = 32


@dataclass(frozen=True)
class Threshold:
    """Of one graph: the ``smallest`` K from which on the path is the shortest one, and the proved ``bound`` on it.

    ``gap``: by how much the second-shortest path is longer; ``longest``: the longest arc, which K must exceed in any
    case; ``pieces``: intervals by which everything from (1 + PRECISION) ``smallest`` up to the bound was certified;
    ``holds_below``: the path is the shortest one at some K below ``smallest`` as well.
    """

    smallest: float
    bound: float
    gap: float
    longest: float
    pieces: int
    holds_below: bool


def threshold(graph: GridGraph) -> Threshold:
    """Climb to the last crossing from below, then certify everything from there up to the proved bound."""
    longest = float(graph.d.max())
    gap = second_cost(graph, graph.d) - graph.shortest_length
    bound = learning.sufficient_K(graph.weights(graph.shortest), gap, longest)
    lowest, pieces = longest * _ABOVE, 0
    start = lowest
    while True:
        smallest = climb(graph, start, bound)
        crossing, count = certify(graph, smallest * (1.0 + PRECISION), bound)
        pieces += count
        if crossing is None:
            break
        start = crossing
    probes = np.geomspace(lowest, smallest, _PROBES, endpoint=False) if smallest > lowest else ()
    below = any(_rival(graph, K) is None for K in probes)
    return Threshold(smallest, bound, gap, longest, pieces, below)


def climb(graph: GridGraph, K: float, bound: float) -> float:
    """From K upwards to where the shortest path is optimal: at each failure go to where that path stops being cheaper.

    Every other path costs more than the shortest one at ``bound``, so each has such a crossing; K only rises.
    """
    weights = graph.weights(graph.shortest)
    while (rival := _rival(graph, K)) is not None:
        K = max(_crossing(rival, weights, K, bound), K) * _ABOVE
    return K


def _crossing(rival: Floats, weights: Floats, low: float, high: float) -> float:
    """The K in [low, high] at which paths of these weights cost the same."""
    from scipy.optimize import brentq

    root: Any = brentq(
        lambda K: learning.log_cost(rival, K) - learning.log_cost(weights, K), low, high, xtol=1e-12, maxiter=200
    )
    return float(root)


def certify(graph: GridGraph, low: float, high: float) -> tuple[float | None, int]:
    """That the shortest path p* is optimal at every K in [low, high]: (None, number of intervals), or a K of doubt.

    With kappa = 1 / K an arc costs g(kappa) = -ln(1 - w kappa) / kappa (K times its share of C_K), a power series with
    positive coefficients and so convex. On an interval of kappa every other path costs at least the sum of its arcs'
    tangents, a line; the least of these lines is concave. p* costs at most its chord, a line too. So if at both ends
    the best other path by tangents costs more than p*, it does so in between. Where it is not, the interval is halved.
    """
    stack, count = [(1.0 / high, 1.0 / low)], 0
    while stack:
        a, b = stack.pop()
        count += 1
        if a < b and not _is_certain(graph, a, b):
            middle = 0.5 * (a + b)
            if b - a < _NARROWEST * b:
                return 1.0 / middle, count
            stack += [(middle, b), (a, middle)]
    return None, count


def second_cost(graph: GridGraph, cost: Floats) -> float:
    """The least ``cost`` (n_arcs,) of a path other than the Euclidean shortest one.

    Another simple path lacks at least one arc of that one, so it is the best of the paths that must do without one.
    """
    best = np.inf
    for arc in graph.network.arcs_along(graph.shortest):
        without = cost.copy()
        without[arc] = np.inf
        best = min(best, dijkstra_path(graph.network, without)[1])
    return best


def _is_certain(graph: GridGraph, a: float, b: float) -> bool:
    middle, weights = 0.5 * (a + b), graph.weights(graph.shortest)
    value = _scaled(graph.d, middle)
    slope = (graph.d / (1.0 - graph.d * middle) - value) / middle
    for end in (a, b):
        tangents = value + (end - middle) * slope
        # far from its point a tangent can fall below 0, where Dijkstra's algorithm is no longer one
        if tangents.min() < 0.0 or second_cost(graph, tangents) <= _scaled(weights, end).sum():
            return False
    return True


def _scaled(d: Floats, kappa: float) -> Floats:
    """g(kappa) of arcs of length d."""
    return -np.log1p(-d * kappa) / kappa


def _rival(graph: GridGraph, K: float) -> Floats | None:
    """The weights of the path that eq. (wb) takes at K, None where that is the shortest path."""
    path, _ = dijkstra_path(graph.network, -np.log1p(-graph.d / K))
    return None if graph.is_shortest(path) else graph.weights(path)
