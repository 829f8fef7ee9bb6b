"""Small graphs, and answers about them that are found by looking at every path."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planner import gabf, learning


def network_of(pairs: list[tuple[int, int]], n: int, source: int = 0) -> gabf.Network:
    """Both arcs of every pair, untrained."""
    arcs = np.array(sorted({*pairs, *((j, i) for i, j in pairs)}), dtype=np.int64).reshape(-1, 2)
    return learning.untrained(arcs[:, 0], arcs[:, 1], np.array([source]), n)


def random_network(seed: int, n: int = 7) -> tuple[gabf.Network, np.ndarray]:
    """A connected graph on points of the unit square, and its distances; node 0 is the source."""
    rng = np.random.default_rng(seed)
    points = rng.random((n, 2))
    tree = [(i, int(rng.integers(i))) for i in range(1, n)]
    more = [(i, j) for i in range(n) for j in range(i) if rng.random() < 0.5]
    network = network_of([*tree, *more], n)
    return network, np.linalg.norm(points[network.tails] - points[network.indices], axis=1)


def simple_paths(network: gabf.Network, node: int, been: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    """The arc ids of every path from ``node`` to a source that visits no node twice."""
    if node in network.sources:
        yield ()
        return
    for arc in range(int(network.indptr[node]), int(network.indptr[node + 1])):
        head = int(network.indices[arc])
        if head not in been and head != node:
            for rest in simple_paths(network, head, (*been, node)):
                yield (arc, *rest)
