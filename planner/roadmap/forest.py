"""Nodes and the motions between them while they are being collected."""

from __future__ import annotations

import itertools
from collections.abc import Set
from functools import cached_property

import numpy as np

from planner.base.arrays import Floats, Ints


class Forest:
    """Nodes by their exact values, so that a configuration of two planners is one node."""

    def __init__(self, nodes: Floats | None = None, edges: Ints | None = None) -> None:
        self._first = np.zeros((0, 0)) if nodes is None else np.array(nodes, dtype=np.float64)
        self._added: list[Floats] = []
        self._edges: list[tuple[int, int]] = [] if edges is None else [(i, j) for i, j in edges.tolist()]

    @cached_property
    def _index(self) -> dict[bytes, int]:
        data, width = self._first.tobytes(), self._first.itemsize * self._first.shape[1]
        return {data[k * width : (k + 1) * width]: k for k in range(len(self._first))}

    @property
    def known(self) -> Set[bytes]:
        """The nodes as bytes."""
        return self._index.keys()

    def __len__(self) -> int:
        return len(self._first) + len(self._added)

    def add(self, q: Floats) -> int:
        """The number of the node at ``q`` (dof,), which becomes one if it is none."""
        count = len(self)
        index = self._index.setdefault(q.tobytes(), count)
        if index == count:
            self._added.append(q.copy())  # a row of a larger array would keep all of it
        return index

    def add_edge(self, a: Floats, b: Floats) -> None:
        i, j = self.add(a), self.add(b)
        if i != j:
            self._edges.append((min(i, j), max(i, j)))

    def add_path(self, path: Floats) -> None:
        for a, b in itertools.pairwise(path):
            self.add_edge(a, b)

    def nodes(self) -> Floats:
        parts = [np.array(rows) for rows in (self._first, self._added) if len(rows)]
        return np.concatenate(parts) if parts else self._first

    def edges(self) -> Ints:
        unique = dict.fromkeys(self._edges)
        return np.array(list(unique), dtype=np.int64).reshape(-1, 2)
