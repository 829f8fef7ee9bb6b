"""The graphs of the paper's third simulation: 36 nodes on a perturbed grid, linked within a range of 0.25."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import AssumptionError
from planner.gabf import Network
from planner.gabf.learning import make_untrained_network

SIDE_NODES = 6
OFFSET = 0.05
RANGE = 0.25
START, GOAL = 0, SIDE_NODES**2 - 1
"""The nodes at the bottom left and the top right."""

_ATTEMPTS = 1000


@dataclass(frozen=True, eq=False)
class GridGraph:
    """A connected graph: ``position`` (36, 2), ``network`` untrained, ``d`` (n_arcs,) Euclidean distances.

    ``redraws`` counts the graphs rejected before it because some node had no path to the goal.
    """

    position: Floats
    network: Network
    d: Floats
    redraws: int

    @cached_property
    def shortest(self) -> Ints:
        """The Euclidean shortest path from START to GOAL, by scipy.sparse.csgraph.dijkstra."""
        _, towards = dijkstra(_matrix(self.network, self.d).T, indices=GOAL, return_predecessors=True)
        path = [START]
        while path[-1] != GOAL:
            path.append(int(towards[path[-1]]))
        return np.array(path, dtype=np.int64)

    def is_shortest(self, path: Ints) -> bool:
        """Whether a node sequence is the Euclidean shortest path."""
        return bool(np.array_equal(path, self.shortest))

    def length(self, path: Ints) -> float:
        """Euclidean length of a node sequence."""
        return float(np.linalg.norm(np.diff(self.position[path], axis=0), axis=1).sum())


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
    return dijkstra(_matrix(network, cost).T, indices=GOAL)


def _matrix(network: Network, cost: Floats) -> csr_matrix:
    return csr_matrix((cost, (network.tails, network.indices)), shape=(network.n_nodes, network.n_nodes))


def _linked(position: Floats) -> tuple[Network, Floats]:
    d = np.linalg.norm(position[:, None] - position[None], axis=2)
    i, j = np.nonzero((d <= RANGE) & ~np.eye(len(position), dtype=bool))
    return make_untrained_network(i, j, np.array([GOAL]), len(position)), d[i, j]
