"""The random graphs of section (comparison): nodes in a square, arcs between near ones, one source."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import AssumptionError, OptionError

SIDE = 10.0
"""Side of the square, km."""

OUT_DEGREE = 10.0
"""Mean number of out-neighbours per node."""

START = 10.0
"""x_i(0) of the first law, km, which must overestimate every x_i*."""

_CANDIDATES = 2.0
_ATTEMPTS = 200


@dataclass(frozen=True, eq=False)
class RandomGraph:
    """A graph with everything it was drawn with: ``position`` (n, 2) km, ``x_star`` (n,) km, ``radius`` km.

    ``redraws`` counts the graphs thrown away before it: ``cut_off`` of them had a node without a path to the source,
    the others an x_i* above the start.
    """

    network: gabf.Network
    position: Floats
    x_star: Floats
    radius: float
    redraws: int
    cut_off: int

    @property
    def source(self) -> int:
        return int(self.network.sources[0])

    @property
    def out_degree(self) -> float:
        """Mean number of out-neighbours."""
        return self.network.n_arcs / self.network.n_nodes


def draw_graph(
    rng: np.random.Generator, nodes: int = 500, out_degree: float = OUT_DEGREE, start: float = START
) -> RandomGraph:
    """Draw until every node reaches the source and ``start`` is a strict overestimate of every x_i* (km).

    ``nodes`` uniform points in a 10 km x 10 km square; pairs closer than ``radius`` are candidates, about twice as
    many as needed, and each of the two arcs of a pair is kept or not at random, so that the mean out-degree is
    ``out_degree`` and about four arcs in ten have no reverse arc. Weights are distances in km, the kernel is a + b.

    The source is the node nearest to the middle of the square. The paper does not say where its source is; at a
    corner the far corner is 14 km away, and x(0) = 10 would be no overestimate. Raises OptionError where the
    nodes are too few for the degree, AssumptionError where 200 draws were not enough.
    """
    if not 1.0 <= out_degree <= (nodes - 1) / (2.0 * _CANDIDATES):
        raise OptionError(
            f"{nodes} nodes are too few for {out_degree:g} out-neighbours each: draw at least 4 times more."
        )
    cut_off = 0
    for redraws in range(_ATTEMPTS):
        position = rng.uniform(0.0, SIDE, (nodes, 2))
        radius = SIDE * float(np.sqrt(_CANDIDATES * out_degree / (np.pi * nodes)))
        i, j = _thinned(rng, position, radius, out_degree).T
        length = np.linalg.norm(position[i] - position[j], axis=1)
        middle = np.array([np.argmin(np.linalg.norm(position - SIDE / 2.0, axis=1))])
        network = gabf.Network.from_arcs(i, j, length, middle, nodes, kernel=gabf.Additive())
        x_star = gabf.oracle(network)
        if x_star.max() < start:
            return RandomGraph(network, frozen(position), frozen(x_star), radius, redraws, cut_off)
        cut_off += int(np.isinf(x_star).any())
    raise AssumptionError(
        f"{_ATTEMPTS} graphs of {nodes} nodes with {out_degree:g} out-neighbours each were drawn, and in none does "
        f"every node reach the source for less than {start:g} km: raise the number of nodes or of out-neighbours."
    )


def _thinned(rng: np.random.Generator, position: Floats, radius: float, out_degree: float) -> Ints:
    """Arcs (k, 2), ascending, kept from both directions of every pair closer than ``radius``."""
    from scipy.spatial import KDTree

    pairs = KDTree(position).query_pairs(radius, output_type="ndarray").astype(np.int64)
    both = np.concatenate((pairs, pairs[:, ::-1]))
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    return both[rng.random(len(both)) < out_degree * len(position) / max(1, len(both))]
