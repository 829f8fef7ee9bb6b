"""The directed graph that GABF runs on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints, frozen, indices, plain_numbers, ranges, so_far
from planner.base.errors import AssumptionError
from planner.gabf.arcmaps import ArcMap
from planner.gabf.kernels import Kernel, TradeOff


@dataclass(frozen=True, eq=False)
class Network:
    """G = (V, E) with weights, sources and a kernel; an arc (i, j) means that node i reads node j, as in the paper.

    ``indptr`` (n + 1,), ``indices`` (n_arcs,), ``weight`` (n_arcs,): the arcs of node i are
    ``indices[indptr[i]:indptr[i + 1]]``; parallel arcs are allowed, self-loops are not (i is not in N(i)).
    ``sources`` (k,) node indices held at ``source_values`` (k,), 0 where left out. ``node_cost`` (n,) is
    omega(j) of eq. (finew), ``arc_cost`` (n_arcs,) a second cost an arc, for the kernels that read them.
    Raises AssumptionError, naming the node, where the arrays are not a graph.

        net = Network([0, 0, 1, 3], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], kernel=Additive())
        solve(net).x        # [0, 1, 2]
    """

    indptr: Ints
    indices: Ints
    weight: Floats
    sources: Ints
    source_values: Floats | None = None
    node_cost: Floats | None = None
    arc_cost: Floats | None = None
    kernel: Kernel = field(default_factory=lambda: TradeOff(beta=0.5))

    def __post_init__(self) -> None:
        for name in ("indptr", "indices", "sources"):
            self._freeze(name, np.int64)
        if self.source_values is None:
            object.__setattr__(self, "source_values", np.zeros(self.sources.size))
        for name in ("weight", "source_values", "node_cost", "arc_cost"):
            if getattr(self, name) is not None:
                self._freeze(name, np.float64)
        _check_arcs(self)
        _check_sources(self)
        _check_finite(self)
        _ = self.arcs

    def __repr__(self) -> str:
        return f"<Network: {len(self.indptr) - 1} nodes, {len(self.indices)} arcs, {len(self.sources)} sources>"

    @staticmethod
    def from_arcs(
        tails: Ints,
        heads: Ints,
        weight: Floats,
        sources: Ints,
        n_nodes: int,
        arc_cost: Floats | None = None,
        **more: Any,
    ) -> Network:
        """The network of arcs (tails[k], heads[k]), (n_arcs,) each, in any order; ``more`` are its other fields.

        Network.from_arcs([1, 2, 2], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], n_nodes=3, kernel=Additive())
        """
        if n_nodes < 1:
            raise AssumptionError(f"{n_nodes} nodes make no network: give at least one")
        tails, heads = _integers("tails", tails), _integers("heads", heads)
        weight = plain_numbers("weight", weight, AssumptionError)
        arc_cost = None if arc_cost is None else plain_numbers("arc_cost", arc_cost, AssumptionError)
        _check_listed(n_nodes, tails, heads, {"heads": heads, "weight": weight, "arc_cost": arc_cost})
        order = np.argsort(tails * n_nodes + heads, kind="stable")  # a fifth of lexsort's time
        return Network(
            indptr=so_far(np.bincount(tails, minlength=n_nodes)),
            indices=heads[order],
            weight=weight[order],
            sources=sources,
            arc_cost=None if arc_cost is None else arc_cost[order],
            **more,
        )

    def _freeze(self, name: str, dtype: type) -> None:
        value = getattr(self, name)
        read = _integers(name, value) if dtype is np.int64 else plain_numbers(name, value, AssumptionError)
        object.__setattr__(self, name, frozen(read, dtype))

    @property
    def n_nodes(self) -> int:
        return self.indptr.size - 1

    @property
    def n_arcs(self) -> int:
        return self.indices.size

    @cached_property
    def tails(self) -> Ints:
        """(n_arcs,) the node i that owns each arc (i, j)."""
        return frozen(np.repeat(np.arange(self.n_nodes), np.diff(self.indptr)), np.int64)

    @cached_property
    def arcs(self) -> ArcMap:
        """The kernel bound to every arc."""
        return self.kernel.bind(self)  # pyright: ignore[reportArgumentType]  (a cached property is one)

    def arcs_between(self, i: int, j: int) -> Ints:
        """Ids of the arcs through which node i reads node j (several if parallel, none if not linked)."""
        _require_nodes(np.array([i, j]), self.n_nodes, "node {1} is not there")
        first, last = self.indptr[i], self.indptr[i + 1]
        return first + np.flatnonzero(self.indices[first:last] == j)

    def arcs_along(self, nodes: Ints) -> Ints:
        """Ids of the arcs (k - 1,) through which each of ``nodes`` (k,) reads the next one, the first of parallel ones.

        Raises :class:`AssumptionError` where two of them are not linked.
        """
        nodes = indices("nodes", nodes, ("k",), self.n_nodes, AssumptionError)
        tails, heads = nodes[:-1], nodes[1:]
        first, counts = self.indptr[tails], np.diff(self.indptr)[tails]
        arcs, step = ranges(first, counts), np.repeat(np.arange(len(tails)), counts)
        there = np.flatnonzero(self.indices[arcs] == heads[step])
        linked, rows = np.unique(step[there], return_index=True)
        if len(linked) < len(tails):
            lost = int(np.setdiff1d(np.arange(len(tails)), linked)[0])
            raise AssumptionError(f"node {tails[lost]} does not read node {heads[lost]}: give nodes of a path")
        return arcs[there[rows]]

    def without_arcs(self, arcs: Ints) -> Network:
        """The same network lacking these arc ids; the ids of later arcs move down."""
        keep = np.ones(self.n_arcs, dtype=bool)
        keep[indices("arcs", arcs, ("k",), self.n_arcs, AssumptionError)] = False
        kept = np.concatenate(([0], np.cumsum(keep)))[self.indptr]
        arc_cost = None if self.arc_cost is None else self.arc_cost[keep]
        return replace(self, indptr=kept, indices=self.indices[keep], weight=self.weight[keep], arc_cost=arc_cost)


def _integers(name: str, values: Ints) -> Ints:
    try:
        array = np.asarray(values)
    except ValueError:
        raise AssumptionError(f"{name} must be one row of integers, and its rows are of several lengths") from None
    if array.size and array.dtype.kind not in "iu":
        raise AssumptionError(f"{name} must hold integers, not {array.dtype}: they are node indices")
    return array.astype(np.int64, copy=False)


def _check_listed(n: int, tails: Ints, heads: Ints, columns: Mapping[str, Ints | Floats | None]) -> None:
    """Refuse a list of arcs with a column that is longer or shorter, or an end that is none of ``n`` nodes."""
    for name, column in columns.items():
        if column is not None and (tails.ndim != 1 or np.shape(column) != tails.shape):
            raise AssumptionError(
                f"{name} has shape {np.shape(column)} and tails {tails.shape}: give one row of each, one entry an arc"
            )
    _require_nodes(tails, n, "tails[{0}] is {1}")
    _require_nodes(heads, n, "heads[{0}] is {1}")


def _require_nodes(given: Ints, n: int, complaint: str) -> None:
    """Refuse the first of the ``given`` that is none of ``n`` nodes; the complaint reads its place and itself."""
    outside = np.flatnonzero((given < 0) | (given >= n))
    if outside.size:
        raise AssumptionError(f"{complaint.format(outside[0], given[outside[0]])}; nodes run from 0 to {n - 1}")


def _check_arcs(net: Network) -> None:
    n, arcs = net.n_nodes, net.n_arcs
    if net.indptr.ndim != 1 or n < 1 or net.indptr[0] != 0 or (np.diff(net.indptr) < 0).any():
        raise AssumptionError("indptr must be one row of n + 1 non-decreasing offsets that starts at 0")
    if net.indices.ndim != 1 or net.indptr[-1] != arcs or net.weight.shape != (arcs,):
        raise AssumptionError(
            f"indptr ends at {net.indptr[-1]}, with {arcs} indices and weights of shape {net.weight.shape}: "
            "all three must agree on the number of arcs"
        )
    _require_nodes(net.indices, n, "arc {0} reads node {1}")
    loops = np.flatnonzero(net.indices == net.tails)
    if loops.size:
        raise AssumptionError(f"node {net.indices[loops[0]]} reads itself: remove that self-loop")


def _check_sources(net: Network) -> None:
    if net.sources.ndim != 1 or net.sources.size == 0:
        raise AssumptionError("give at least one source: assumption (main) needs a non-empty source set")
    _require_nodes(net.sources, net.n_nodes, "source {1} is not a node")
    if len(set(net.sources.tolist())) != net.sources.size:
        raise AssumptionError("a source is listed twice: list each source once")


def _check_finite(net: Network) -> None:
    sizes = {"source_values": net.sources.size, "node_cost": net.n_nodes, "arc_cost": net.n_arcs, "weight": net.n_arcs}
    for name, size in sizes.items():
        if (array := getattr(net, name)) is None:
            continue
        if array.shape != (size,):
            raise AssumptionError(f"{name} has shape {array.shape} where ({size},) is needed")
        bad = np.flatnonzero(~np.isfinite(array))
        if bad.size:
            raise AssumptionError(
                f"{name}[{bad[0]}] is {array[bad[0]]}: every value must be finite; leave out blocked arcs"
            )
