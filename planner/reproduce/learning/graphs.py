"""The graphs of the paper's third simulation: 36 nodes on a perturbed grid, linked within a range of 0.25."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner import learning
from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import AssumptionError
from planner.gabf import Network

SIDE_NODES = 6
OFFSET = 0.05
RANGE = 0.25
START, GOAL = 0, SIDE_NODES**2 - 1
"""The nodes at the bottom left and the top right."""

_ATTEMPTS = 1000


@dataclass(frozen=True, eq=False)
class GridGraph:
    """A connected graph: ``position`` (36, 2), ``network`` untrained, ``d`` (n_arcs,) Euclidean distances.

    ``redraws`` counts the graphs thrown away before it because some node had no path to the goal.
    """

    position: Floats
    network: Network
    d: Floats
    redraws: int

    @cached_property
    def shortest(self) -> Ints:
        """The Euclidean shortest path from START to GOAL, by scipy.sparse.csgraph.dijkstra."""
        return dijkstra_path(self.network, self.d)[0]

    @cached_property
    def shortest_length(self) -> float:
        return self.length(self.shortest)

    @property
    def outside(self) -> int:
        """How many nodes the offset moved out of [0, 1] x [0, 1]."""
        return int(((self.position < 0.0) | (self.position > 1.0)).any(axis=1).sum())

    def is_shortest(self, path: Ints) -> bool:
        """Whether a node sequence is the Euclidean shortest path."""
        return bool(np.array_equal(path, self.shortest))

    def length(self, path: Ints) -> float:
        """Euclidean length of a node sequence."""
        return float(np.linalg.norm(np.diff(self.position[path], axis=0), axis=1).sum())

    def weights(self, path: Ints) -> Floats:
        """(k - 1,) the distances along a node sequence."""
        return self.d[self.network.arcs_along(path)]


def draw_grid(rng: np.random.Generator) -> GridGraph:
    """Draw until every node has a path to the goal; AssumptionError where 1000 draws were not enough.

    Six by six nodes at multiples of 1/5, each coordinate moved by a uniform offset in [-0.05, 0.05]. The paper does not
    say where in the square its grid lies; this one starts and ends in the corners.
    """
    ticks = np.linspace(0.0, 1.0, SIDE_NODES)
    grid = np.array([(x, y) for y in ticks for x in ticks])
    for redraws in range(_ATTEMPTS):
        position = grid + rng.uniform(-OFFSET, OFFSET, grid.shape)
        network, d = _linked(position)
        if np.isfinite(distances(network, d)).all():
            return GridGraph(frozen(position), network, frozen(d), redraws)
    raise AssumptionError(f"none of {_ATTEMPTS} drawn grids is connected within a range of {RANGE:g}: raise the range.")


def distances(network: Network, cost: Floats) -> Floats:
    """(n,) least sum of ``cost`` (n_arcs,) along arcs from each node to the goal, by SciPy; +inf without a path."""
    from scipy.sparse.csgraph import dijkstra

    return dijkstra(_matrix(network, cost).T, indices=GOAL)


def dijkstra_path(network: Network, cost: Floats) -> tuple[Ints, float]:
    """The path of least ``cost`` (n_arcs,) from START to GOAL and that cost, by SciPy; an empty path if there is none.

    Arcs of infinite cost count as missing.
    """
    from scipy.sparse.csgraph import dijkstra

    total, before = dijkstra(_matrix(network, cost), indices=START, return_predecessors=True)
    if not np.isfinite(total[GOAL]):
        return np.zeros(0, dtype=np.int64), np.inf
    path = [GOAL]
    while path[-1] != START:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], dtype=np.int64), float(total[GOAL])


def _matrix(network: Network, cost: Floats):
    from scipy.sparse import csr_matrix

    keep = np.isfinite(cost)
    places = network.tails[keep], network.indices[keep]
    return csr_matrix((cost[keep], places), shape=(network.n_nodes, network.n_nodes))


def _linked(position: Floats) -> tuple[Network, Floats]:
    d = np.linalg.norm(position[:, None] - position[None], axis=2)
    i, j = np.nonzero((d <= RANGE) & ~np.eye(len(position), dtype=bool))
    return learning.untrained(i, j, np.array([GOAL]), len(position)), d[i, j]
