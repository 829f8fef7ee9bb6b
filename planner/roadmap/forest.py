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
        self._nodes: list[Floats] = [] if nodes is None else list(nodes)
        self._edges: list[tuple[int, int]] = [] if edges is None else [(int(i), int(j)) for i, j in edges]

    @cached_property
    def _index(self) -> dict[bytes, int]:
        return {q.tobytes(): k for k, q in enumerate(self._nodes)}

    @property
    def known(self) -> Set[bytes]:
        """The nodes as bytes."""
        return self._index.keys()

    def __len__(self) -> int:
        return len(self._nodes)

    def add(self, q: Floats) -> int:
        index = self._index.setdefault(q.tobytes(), len(self._nodes))
        if index == len(self._nodes):
            self._nodes.append(q.copy())  # a row of a larger array would keep all of it
        return index

    def add_edge(self, a: Floats, b: Floats) -> None:
        i, j = self.add(a), self.add(b)
        if i != j:
            self._edges.append((min(i, j), max(i, j)))

    def add_path(self, path: Floats) -> None:
        for a, b in itertools.pairwise(path):
            self.add_edge(a, b)

    def nodes(self) -> Floats:
        return np.array(self._nodes)

    def edges(self) -> Ints:
        unique = dict.fromkeys(self._edges)
        return np.array(list(unique), dtype=np.int64).reshape(-1, 2)
