"""The part of a network that the dynamics acts on: the nodes that reach a source, and the arcs between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Bools, Floats, Ints, plain_numbers
from planner.base.errors import AssumptionError
from planner.gabf.kernels import ArcMap
from planner.gabf.network import Network
from planner.native.compiled import hops_to_source


class Standing(NamedTuple):
    """States ``y`` (R + S,), ``xhat`` (R,) = y - m of eq. (xhat), its largest size, and the range of the rows' y.

    ``lowest_moving``: the least of y and m over the rows that move, xhat other than 0; inf where none does.
    """

    y: Floats
    xhat: Floats
    residual: float
    lowest: float
    highest: float
    lowest_moving: float

    @property
    def largest(self) -> float:
        """The largest |y| of the rows."""
        return max(abs(self.lowest), abs(self.highest))


@dataclass(frozen=True, eq=False)
class Problem:
    """The nodes that reach a source: the R non-source ones (rows) first, then the S sources.

    Row i reads the states at ``heads[starts[i]:starts[i + 1]]`` through ``arcs``, at least one. ``nodes`` (R + S,) are
    indices in the network, ``anchors`` (S,) the values of the sources; ``heads`` are positions in ``nodes``, ``arcs``
    the arcs ``arc_ids`` of the network. ``hops`` (R,) fewest arcs to a source.
    """

    network: Network
    starts: Ints
    heads: Ints
    arcs: ArcMap
    nodes: Ints
    anchors: Floats
    arc_ids: Ints
    hops: Ints

    @property
    def n_rows(self) -> int:
        return self.starts.size

    @property
    def rows(self) -> Ints:
        return self.nodes[: self.n_rows]

    @cached_property
    def owners(self) -> Ints:
        """(A,) the row that each arc belongs to."""
        return np.repeat(np.arange(self.n_rows), np.diff(self.starts, append=self.heads.size))

    def parent_values(self, y: Floats) -> Floats:
        """(R,) m_i = min_j f_i(y_j, w_ij)."""
        if self.n_rows == 0:
            return np.empty(0)
        return np.minimum.reduceat(self.arcs(y[self.heads]), self.starts)

    def disequilibrium(self, y: Floats) -> Floats:
        """xhat (R,), eq. (xhat)."""
        return y[: self.n_rows] - self.parent_values(y)

    def standing(self, y: Floats) -> Standing:
        """How the rows stand at states ``y``."""
        rows, xhat = y[: self.n_rows], self.disequilibrium(y)
        lowest, highest = float(rows.min(initial=np.inf)), float(rows.max(initial=-np.inf))
        moving = float(np.minimum(rows, rows - xhat)[xhat != 0].min(initial=np.inf))
        return Standing(y, xhat, float(np.abs(xhat).max(initial=0.0)), lowest, highest, moving)

    def hops_along(self, arcs: Bools) -> Ints:
        """(R + S,) the fewest of these ``arcs`` (A,) from each node to a source; -1 where they lead to none."""
        counts = np.bincount(self.owners[arcs], minlength=self.nodes.size)
        sources = np.arange(self.n_rows, self.nodes.size)
        return hops_to_source(np.concatenate(([0], np.cumsum(counts))), self.heads[arcs], sources)

    @property
    def most_hops(self) -> int:
        """The largest of ``hops``."""
        return int(self.hops.max(initial=0))

    def climb(self, k: int, a: float) -> float:
        """g_k(a): the largest, over the nodes of k hops, of the cheapest f_ij(a) towards k - 1 hops."""
        arcs, starts = self._stairs[k - 1]
        with np.errstate(over="ignore"):
            return float(np.minimum.reduceat(self.arcs.take(arcs)(np.full(arcs.size, a)), starts).max())

    @cached_property
    def _stairs(self) -> list[tuple[Ints, Ints]]:
        """For 1, 2, .. hops the arcs that lead one hop nearer to the sources, and where each node's begin."""
        hops = np.concatenate((self.hops, np.zeros(self.anchors.size, dtype=np.int64)))
        downhill = np.flatnonzero(hops[self.heads] < hops[self.owners])
        height = hops[self.owners[downhill]]
        downhill = downhill[np.argsort(height, kind="stable")]
        stairs = [downhill[a:b] for a, b in pairwise(np.cumsum(np.bincount(height, minlength=1)))]
        return [(arcs, np.flatnonzero(np.diff(self.owners[arcs], prepend=-1))) for arcs in stairs]

    def mean_cost(self, y: Floats) -> float:
        """What an arc adds on average at state ``y``: the scale that errors of one step are measured by."""
        heads = y[self.heads]
        return float(np.mean(np.abs(self.arcs(heads) - heads))) if self.n_rows else 0.0

    def with_sources(self, rows: Floats) -> Floats:
        """(R + S,) the states ``rows`` (R,), and the sources at their anchors."""
        return np.concatenate((rows, self.anchors))

    def pack(self, x: Floats) -> Floats:
        """States of these nodes from an array over all nodes, sources at their anchors."""
        return self.with_sources(x[self.rows])

    def unpack(self, y: Any, missing: float = np.inf) -> NDArray[Any]:
        """An array over all nodes out of ``y`` (R + S,), or of the rows alone (R,); ``missing`` at all others."""
        x = np.full(self.network.n_nodes, missing, dtype=y.dtype)
        x[self.nodes[: y.size]] = y
        return x


def reduce(net: Network) -> Problem:
    """Leave out sources' arcs, unreachable nodes and arcs into them."""
    hops = hops_to_source(net.indptr, net.indices, net.sources)
    is_row = hops > 0
    nodes = np.concatenate((np.flatnonzero(is_row), net.sources))
    position = np.full(net.n_nodes, -1, dtype=np.intp)
    position[nodes] = np.arange(nodes.size)
    arc_ids = np.flatnonzero(is_row[net.tails] & (hops[net.indices] >= 0))
    counts = np.bincount(position[net.tails[arc_ids]], minlength=nodes.size - net.sources.size)
    assert net.source_values is not None
    return Problem(
        network=net,
        starts=np.cumsum(counts) - counts,
        heads=position[net.indices[arc_ids]],
        arcs=net.arcs.take(arc_ids),
        nodes=nodes,
        anchors=net.source_values,
        arc_ids=arc_ids,
        hops=hops[is_row],
    )


def states(net: Network, x: Any, name: str) -> Floats:
    """``x`` as one state a node (n,), finite or not; AssumptionError otherwise."""
    result = plain_numbers(name, x, AssumptionError)
    if result.shape != (net.n_nodes,):
        raise AssumptionError(f"{name} has shape {result.shape} where ({net.n_nodes},) is needed: one state a node")
    return result


def field(problem: Problem, x: Any, name: str) -> Floats:
    """``x`` as :func:`states` has it, finite at every reachable node."""
    result = states(problem.network, x, name)
    bad = problem.nodes[~np.isfinite(result[problem.nodes])]
    if bad.size:
        raise AssumptionError(f"{name}[{bad[0]}] is {result[bad[0]]}: every state must be finite")
    return result
