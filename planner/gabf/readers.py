"""The reversed graph: which arcs read a node."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Ints, ranges


class Readers:
    """Arcs by the node that they lead to; ``heads`` (n_arcs,) are nodes below ``n_nodes``."""

    def __init__(self, heads: Ints, n_nodes: int) -> None:
        self._order = np.argsort(heads, kind="stable")
        self._indptr = np.concatenate(([0], np.cumsum(np.bincount(heads, minlength=n_nodes))))

    def of(self, nodes: Ints) -> Ints:
        """The arcs (k,) that read one of ``nodes``."""
        return self._order[ranges(self._indptr[nodes], self._indptr[nodes + 1] - self._indptr[nodes])]
