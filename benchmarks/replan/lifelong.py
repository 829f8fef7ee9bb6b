"""The baseline for a healing field: LPA* and D* Lite from the same field, over any increasing progressive kernel.

Koenig, Likhachev and Furcy 2004; Koenig and Likhachev 2002. A settled field is a consistent state of theirs (g = rhs),
so a repair begins with the nodes whose right-hand side is another in the changed network. Without a heuristic, as no
distance bounds these costs from below.
"""

from __future__ import annotations

import heapq
import itertools
from dataclasses import dataclass

import numpy as np

from planner import gabf
from planner.base.arrays import Floats
from planner.gabf.reverse_adjacency import Readers


@dataclass(frozen=True, eq=False)
class Repaired:
    """The repaired field x (n,), and how many right-hand sides it took: for all nodes, and until ``start`` settled."""

    x: Floats
    updates: int
    updates_to_start: int


def repair_field(network: gabf.Network, x: Floats, start: int) -> Repaired:
    """The field of ``network`` from the settled field ``x`` (n,) of another network on the same nodes."""
    search = _Search(network, x)
    to_start: int | None = None
    while search.queue:
        key, node = heapq.heappop(search.queue)
        if search.key_of(node) != key or not search.is_open(node):
            continue  # an entry of before
        if to_start is None and key >= search.key_of(start) and not search.is_open(start):
            to_start = search.updates
        search.expand(node)
    return Repaired(np.array(search.g), search.updates, search.updates if to_start is None else to_start)


class _Search:
    def __init__(self, network: gabf.Network, x: Floats) -> None:
        self._network, self.updates = network, 0
        self._sources = set(network.sources.tolist())
        readers = Readers(network.indices, network.n_nodes)
        self._readers = [network.tails[readers.order[a:b]].tolist() for a, b in itertools.pairwise(readers.indptr)]
        spans = list(itertools.pairwise(network.indptr))
        self._arcs = [network.arcs.take(np.arange(a, b)) for a, b in spans]
        self._heads = [network.indices[a:b] for a, b in spans]
        self.g = np.where(np.isfinite(x), x, np.inf)
        anchors = network.source_values
        assert anchors is not None
        self._anchor = dict(zip(network.sources.tolist(), anchors.tolist(), strict=True))
        self.rhs = [self._right_side(i) for i in range(network.n_nodes)]
        self.queue = [(self.key_of(i), i) for i in range(network.n_nodes) if self.is_open(i)]
        self.updates = len(self.queue)  # a robot knows which costs changed: only those nodes count
        heapq.heapify(self.queue)

    def key_of(self, node: int) -> float:
        return min(float(self.g[node]), self.rhs[node])

    def is_open(self, node: int) -> bool:
        return float(self.g[node]) != self.rhs[node]

    def expand(self, node: int) -> None:
        """Make a node consistent from above, or give it up and ask its readers and itself again."""
        if self.g[node] > self.rhs[node]:
            self.g[node] = self.rhs[node]
            asked = self._readers[node]
        else:
            self.g[node] = np.inf
            asked = [*self._readers[node], node]
        for other in asked:
            self._update(other)

    def _update(self, node: int) -> None:
        if node not in self._sources:
            self.updates += 1
            self.rhs[node] = self._right_side(node)
        if self.is_open(node):
            heapq.heappush(self.queue, (self.key_of(node), node))

    def _right_side(self, node: int) -> float:
        if node in self._sources:
            return self._anchor[node]
        heads = self._heads[node]
        return float(self._arcs[node](self.g[heads]).min(initial=np.inf))
