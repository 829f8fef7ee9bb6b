"""Nodes and the motions between them while they are being collected."""

from __future__ import annotations

import itertools

import numpy as np

from planner.base.arrays import Floats, Ints

_FEW = 64  # rows that are looked for one by one; an index of many nodes pays from some hundred on


class Forest:
    """Nodes by their exact values, so that a configuration of two planners is one node."""

    def __init__(self, nodes: Floats | None = None, edges: Ints | None = None) -> None:
        self._first = np.zeros((0, 0)) if nodes is None else np.array(nodes, dtype=np.float64)
        self._added: list[Floats] = []
        self._edges: list[tuple[int, int]] = [] if edges is None else [(i, j) for i, j in edges.tolist()]
        self._index: dict[bytes, int] = {}  # of what was added, and of the first nodes that were looked for
        self._left = _FEW if len(self._first) else 0

    def __len__(self) -> int:
        return len(self._first) + len(self._added)

    def __contains__(self, q: Floats) -> bool:
        return self._number(q, q.tobytes()) is not None

    def add(self, q: Floats) -> int:
        """The number of the node at ``q`` (dof,), which becomes one if it is none."""
        key = q.tobytes()
        number = self._number(q, key)
        if number is None:
            number = self._index[key] = len(self)
            self._added.append(q.copy())  # a row of a larger array would keep all of it
        return number

    def _number(self, q: Floats, key: bytes) -> int | None:
        number = self._index.get(key)
        if number is not None or not self._left:
            return number
        self._left -= 1
        if not self._left:
            data, width = self._first.tobytes(), len(key)
            first = reversed(range(len(self._first)))  # of nodes that are the same the first one, as row by row
            self._index |= {data[k * width : (k + 1) * width]: k for k in first}
            return self._index.get(key)
        for k in np.flatnonzero(self._first[:, 0] == q[0]).tolist():
            if self._first[k].tobytes() == key:
                self._index[key] = k
                return k
        return None

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
