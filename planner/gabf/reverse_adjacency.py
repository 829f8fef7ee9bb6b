"""The reversed graph: which arcs read a node."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Ints, ranges


class Readers:
    """Arcs by the node that they lead to; ``heads`` (n_arcs,) are nodes below ``n_nodes``.

    Node j is read by the arcs ``order[indptr[j]:indptr[j + 1]]``.
    """

    def __init__(self, heads: Ints, n_nodes: int) -> None:
        self.order = np.argsort(heads, kind="stable")
        self.indptr = np.concatenate(([0], np.cumsum(np.bincount(heads, minlength=n_nodes))))

    def of(self, nodes: Ints) -> Ints:
        """The arcs (k,) that read one of ``nodes``."""
        return self.order[ranges(self.indptr[nodes], self.indptr[nodes + 1] - self.indptr[nodes])]
