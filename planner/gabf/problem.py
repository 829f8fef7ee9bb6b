"""The part of a network that the dynamics acts on, laid out for speed."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Bools, Floats, Ints, plain_numbers
from planner.base.errors import AssumptionError
from planner.gabf.arcmaps import AffineArcs, ArcMap
from planner.gabf.network import Network
from planner.gabf.reverse_adjacency import Readers
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

    @staticmethod
    def of(y: Floats, xhat: Floats) -> Standing:
        rows = y[: xhat.size]
        lowest, highest = float(rows.min(initial=np.inf)), float(rows.max(initial=-np.inf))
        moving = float(np.minimum(rows, rows - xhat)[xhat != 0].min(initial=np.inf))
        return Standing(y, xhat, float(np.abs(xhat).max(initial=0.0)), lowest, highest, moving)


@dataclass(frozen=True, eq=False)
class Rows:
    """States that move: row i reads the states at ``heads[starts[i]:starts[i + 1]]`` through ``arcs``, at least one.

    The states of the R rows come first, behind them those that are only read.
    """

    starts: Ints
    heads: Ints
    arcs: ArcMap

    @property
    def n_rows(self) -> int:
        return self.starts.size

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
        return Standing.of(y, self.disequilibrium(y))


@dataclass(frozen=True, eq=False)
class Problem(Rows):
    """The nodes that reach a source: the R non-source ones (rows) first, then the sources.

    ``nodes`` (R + S,) their indices in the network, ``anchors`` (S,) the values of the sources; ``heads`` are positions
    in ``nodes``, ``arcs`` the arcs ``arc_ids`` of the network. ``hops`` (R,) fewest arcs to a source.
    """

    network: Network
    nodes: Ints
    anchors: Floats
    arc_ids: Ints
    hops: Ints

    @property
    def rows(self) -> Ints:
        return self.nodes[: self.n_rows]

    @cached_property
    def _downhill(self) -> Bools:
        """(A,) the arcs that lead one hop nearer to the sources."""
        hops = np.concatenate((self.hops, np.zeros(self.anchors.size, dtype=np.int64)))
        return hops[self.heads] < hops[self.owners]

    @cached_property
    def readers(self) -> Readers:
        """Which arcs read a node."""
        return Readers(self.heads, self.nodes.size)

    def hops_along(self, arcs: Bools) -> Ints:
        """(R + S,) the fewest of these ``arcs`` (A,) from each node to a source; -1 where they lead to none."""
        counts = np.bincount(self.owners[arcs], minlength=self.nodes.size)
        sources = np.arange(self.n_rows, self.nodes.size)
        return hops_to_source(np.concatenate(([0], np.cumsum(counts))), self.heads[arcs], sources)

    @cached_property
    def climbs(self) -> list[Callable[[float], float]]:
        """g_1, g_2, ..: g_k(a) is the largest, over the nodes of k hops, of the cheapest f_ij(a) towards k - 1 hops."""
        if isinstance(self.arcs, AffineArcs) and self.arcs.slope is None and self.n_rows:
            cheapest = np.minimum.reduceat(np.where(self._downhill, self.arcs.offset, np.inf), self.starts)
            steepest = np.full(int(self.hops.max()), -np.inf)
            np.maximum.at(steepest, self.hops - 1, cheapest)
            return [partial(operator.add, cost) for cost in steepest.tolist()]
        downhill = np.flatnonzero(self._downhill)
        height = self.hops[self.owners[downhill]]
        downhill = downhill[np.argsort(height, kind="stable")]
        ends = np.cumsum(np.bincount(height, minlength=1))
        return [partial(_climb, self._reading_one(downhill[a:b])) for a, b in pairwise(ends)]

    def _reading_one(self, arcs: Ints) -> Rows:
        """The rows of some ``arcs``, all of which read one state."""
        starts = np.flatnonzero(np.diff(self.owners[arcs], prepend=-1))
        return Rows(starts, np.zeros(arcs.size, dtype=np.int64), self.arcs.take(arcs))

    def mean_cost(self, y: Floats) -> float:
        """What an arc adds on average at state ``y``: the scale that errors of one step are measured by."""
        if not self.n_rows:
            return 0.0
        heads = y[self.heads]
        return float(np.mean(np.abs(self.arcs(heads) - heads)))

    def with_sources(self, rows: Floats) -> Floats:
        """(R + S,) the states ``rows`` (R,), and the sources at their anchors."""
        return np.concatenate((rows, self.anchors))

    def swept(self, y: Floats) -> Floats:
        """T'y of eq. (bellman-gabf)."""
        return self.with_sources(self.parent_values(y))

    def settled(self, y: Floats, sweeps: int) -> tuple[Floats, int] | None:
        """T' iterated from ``y`` until nothing changes, and how often it did; None where ``sweeps`` do not suffice."""
        for sweep in range(sweeps + 1):
            swept = self.swept(y)
            if np.array_equal(swept, y):
                return y, sweep
            y = swept
        return None

    def pack(self, x: Floats) -> Floats:
        """States of these nodes from an array over all nodes, sources at their anchors."""
        y = x[self.nodes]
        y[self.n_rows :] = self.anchors
        return y

    def unpack(self, y: Any, missing: float = np.inf) -> NDArray[Any]:
        """An array over all nodes out of ``y`` (R + S,), or of the rows alone (R,); ``missing`` at all others."""
        x = np.full(self.network.n_nodes, missing, dtype=y.dtype)
        x[self.nodes[: y.size]] = y
        return x


def _climb(rows: Rows, a: float) -> float:
    with np.errstate(over="ignore"):
        return float(rows.parent_values(np.array([a])).max())


def reduce(net: Network) -> Problem:
    """Leave out sources' arcs, unreachable nodes and arcs into them."""
    hops = hops_to_source(net.indptr, net.indices, net.sources)
    is_row = hops > 0
    nodes = np.concatenate((np.flatnonzero(is_row), net.sources))
    position = np.full(net.n_nodes, -1, dtype=np.intp)
    position[nodes] = np.arange(nodes.size)
    used = is_row[net.tails] & (hops[net.indices] >= 0)
    arc_ids = np.flatnonzero(used)
    counts = np.bincount(position[net.tails[arc_ids]], minlength=nodes.size - net.sources.size)
    heads = position[net.indices[arc_ids]]
    arcs = net.arcs if arc_ids.size == net.n_arcs else net.arcs.take(arc_ids)
    anchors = net.source_values
    assert anchors is not None
    starts = np.cumsum(counts) - counts
    return Problem(starts, heads, arcs, net, nodes, anchors, arc_ids, hops[is_row])


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
