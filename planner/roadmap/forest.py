"""Nodes and motions between them, while they are collected."""

import itertools

import numpy as np

from planner.base.arrays import Floats, Ints, row_bytes

_FEW = 64  # linear searches before an index is made, which pays from some hundred on


class Forest:
    """Nodes by their exact values, so that equal configurations of two planners are one node."""

    def __init__(self, nodes: Floats | None = None, edges: Ints | None = None) -> None:
        self._first = np.zeros((0, 0)) if nodes is None else np.array(nodes, dtype=np.float64)
        self._added: list[Floats] = []
        self._edges: list[tuple[int, int]] = [] if edges is None else [(i, j) for i, j in edges.tolist()]
        self._index: dict[bytes, int] = {}  # of the added nodes, and of the first nodes once searched
        self._left = _FEW if len(self._first) else 0

    def __len__(self) -> int:
        return len(self._first) + len(self._added)

    def __contains__(self, q: Floats) -> bool:
        return self._number(q, q.tobytes()) is not None

    def add(self, q: Floats) -> int:
        """Return the number of the node at ``q`` (dof,); add it if it is new."""
        return self._add(q, q.tobytes())

    def _add(self, q: Floats, key: bytes) -> int:
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
            self._index_first()
            return self._index.get(key)
        for k in np.flatnonzero(self._first[:, 0] == q[0]).tolist():
            if self._first[k].tobytes() == key:
                self._index[key] = k
                return k
        return None

    def _index_first(self) -> None:
        self._left = 0
        for k, key in enumerate(row_bytes(self._first)):
            self._index.setdefault(key, k)  # the first of equal nodes

    def add_edge(self, a: Floats, b: Floats) -> None:
        self._join(self.add(a), self.add(b))

    def _join(self, i: int, j: int) -> None:
        if i != j:
            self._edges.append((min(i, j), max(i, j)))

    def add_path(self, path: Floats) -> None:
        for a, b in itertools.pairwise(path):
            self.add_edge(a, b)

    def add_edges(self, motions: Floats) -> None:
        """Add ``motions`` (m, 2, dof) in their order, as :meth:`add_edge` of each."""
        self._index_first()
        ends = motions.reshape(-1, motions.shape[2])
        numbers = [self._add(q, key) for q, key in zip(ends, row_bytes(ends), strict=True)]
        for i, j in zip(numbers[::2], numbers[1::2], strict=True):
            self._join(i, j)

    def nodes(self) -> Floats:
        arrays = [np.array(rows) for rows in (self._first, self._added) if len(rows)]
        return np.concatenate(arrays) if arrays else self._first

    def edges(self) -> Ints:
        unique = dict.fromkeys(self._edges)
        return np.array(list(unique), dtype=np.int64).reshape(-1, 2)
