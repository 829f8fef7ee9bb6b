"""The directed graph that GABF runs on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints, cumulative_sums, frozen, indices, numbers, ranges
from planner.base.errors import AssumptionError
from planner.gabf.kernels import Additive, ArcMap, Kernel, TradeOff

_DEFAULT: Any = None  # set by a Network


@dataclass(frozen=True, eq=False)
class Network:
    """G = (V, E) with weights, sources and a kernel; an arc (i, j): node i reads node j, as in the paper.

    ``indptr`` (n + 1,), ``indices`` (n_arcs,), ``weight`` (n_arcs,): the arcs of node i are
    ``indices[indptr[i]:indptr[i + 1]]``; parallel arcs are allowed, self-loops are not (i is not in N(i)). ``sources``
    (k,) are the nodes of constant value ``source_values`` (k,), 0 by default. ``node_cost`` (n,) is omega(j) of eq.
    (finew), ``arc_cost`` (n_arcs,) a second cost per arc, for the kernels that read them. The default ``kernel`` is
    :class:`TradeOff` with a ``node_cost``, else :class:`Additive`, the shortest path. Raises AssumptionError, naming
    the node, where the arrays are not a graph.

    >>> network = gabf.Network([0, 0, 1, 3], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0])
    >>> gabf.solve(network).x
    array([0., 1., 2.])
    """

    indptr: Ints
    indices: Ints
    weight: Floats
    sources: Ints
    source_values: Floats = _DEFAULT
    node_cost: Floats | None = None
    arc_cost: Floats | None = None
    kernel: Kernel = _DEFAULT

    def __post_init__(self) -> None:
        n_arcs, given = np.size(self.indices), dict(vars(self))
        indptr = indices("indptr", self.indptr, ("n + 1",), n_arcs + 1, AssumptionError)
        n = indptr.size - 1
        if n < 1 or indptr[0] != 0 or indptr[-1] != n_arcs or (np.diff(indptr) < 0).any():
            raise AssumptionError(
                f"indptr must hold n + 1 non-decreasing offsets from 0 to {n_arcs}, the number of arcs."
            )
        given["indptr"] = indptr
        given["indices"] = indices("indices", self.indices, (n_arcs,), n, AssumptionError)
        given["sources"] = sources = indices("sources", self.sources, ("k",), n, AssumptionError)
        if self.source_values is None:
            given["source_values"] = np.zeros(sources.size)
        sizes = {"weight": n_arcs, "source_values": sources.size, "node_cost": n, "arc_cost": n_arcs}
        for name, size in sizes.items():
            if given[name] is not None:
                given[name] = numbers(name, given[name], (size,), AssumptionError)
        if self.kernel is None:
            given["kernel"] = Additive() if self.node_cost is None else TradeOff()
        for name, value in given.items():
            object.__setattr__(self, name, frozen(value, value.dtype) if isinstance(value, np.ndarray) else value)
        if (loops := self.indices[self.indices == self.tails]).size:
            raise AssumptionError(f"node {loops[0]} reads itself: remove that self-loop.")
        if np.unique(sources).size != sources.size or not sources.size:
            raise AssumptionError("sources must be distinct nodes, at least one, assumption (main).")
        _ = self.arcs

    def __repr__(self) -> str:
        return f"<Network: {self.n_nodes} nodes, {self.n_arcs} arcs, {len(self.sources)} sources>"

    @staticmethod
    def from_arcs(
        tails: Ints, heads: Ints, weight: Floats, sources: Ints, n_nodes: int, arc_cost: Any = None, **more: Any
    ) -> Network:
        """Return the network of arcs (tails[k], heads[k]), (n_arcs,) each, in any order.

        ``more`` are other fields of the network.

        >>> gabf.Network.from_arcs([1, 2, 2], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], n_nodes=3)
        <Network: 3 nodes, 3 arcs, 1 sources>
        """
        if n_nodes < 1:
            raise AssumptionError(f"n_nodes must be at least 1, got {n_nodes}.")
        tails = indices("tails", tails, ("n_arcs",), n_nodes, AssumptionError)
        heads = indices("heads", heads, (tails.size,), n_nodes, AssumptionError)
        order = np.argsort(tails * n_nodes + heads, kind="stable")
        weight = numbers("weight", weight, (tails.size,), AssumptionError)[order]
        if arc_cost is not None:
            arc_cost = numbers("arc_cost", arc_cost, (tails.size,), AssumptionError)[order]
        indptr = cumulative_sums(np.bincount(tails, minlength=n_nodes))
        return Network(indptr, heads[order], weight, sources, arc_cost=arc_cost, **more)

    @staticmethod
    def from_scipy(graph: Any, sources: Ints, **more: Any) -> Network:
        """Return the network of a SciPy sparse array (n, n): entry (i, j) is the weight of the arc (i, j).

        Stored zeros are arcs too. As node i reads node j, x_i is the cost of the cheapest way from i to a source along
        steps i -> j. So ``graph`` is the usual weighted adjacency matrix, ``networkx.to_scipy_sparse_array(digraph)``,
        and x is ``scipy.sparse.csgraph.dijkstra(graph.T, indices=sources, min_only=True)``. ``more`` are other fields,
        ``arc_cost`` in the order of ``graph.tocsr().data``. Raises TypeError unless ``graph`` is a sparse array, and
        AssumptionError as :class:`Network` does, for self-loops for instance.

        >>> graph = scipy.sparse.csr_array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [5.0, 1.0, 0.0]])
        >>> gabf.solve(gabf.Network.from_scipy(graph, sources=[0])).x
        array([0., 1., 2.])
        """
        if not hasattr(graph, "tocsr"):
            kind = type(graph).__name__
            raise TypeError(f"graph must be a SciPy sparse array, got {kind}: give scipy.sparse.csr_array(graph).")
        if graph.shape != (graph.shape[0], graph.shape[0]):
            raise AssumptionError(f"graph must have a row and a column per node, got shape {graph.shape}.")
        csr = graph.tocsr()
        return Network(csr.indptr, csr.indices, csr.data, sources, **more)

    def to_scipy(self) -> Any:
        """Return the weights as a ``scipy.sparse.csr_array`` (n, n), see :meth:`from_scipy`.

        Its ``data`` has the arcs' order. Parallel arcs stay separate entries: csgraph takes the least, arithmetic adds
        them.

        >>> gabf.Network.from_arcs([1, 2, 2], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], n_nodes=3).to_scipy().toarray()
        array([[0., 0., 0.],
               [1., 0., 0.],
               [5., 1., 0.]])
        """
        from scipy.sparse import csr_array

        return csr_array((self.weight, self.indices, self.indptr), (self.n_nodes, self.n_nodes), copy=True)

    @property
    def n_nodes(self) -> int:
        return self.indptr.size - 1

    @property
    def n_arcs(self) -> int:
        return self.indices.size

    @cached_property
    def tails(self) -> Ints:
        """(n_arcs,) the node i of each arc (i, j)."""
        return frozen(np.repeat(np.arange(self.n_nodes), np.diff(self.indptr)), np.int64)

    @cached_property
    def arcs(self) -> ArcMap:
        """The kernel bound to every arc."""
        return self.kernel.bind(self)

    def arcs_between(self, i: int, j: int) -> Ints:
        """Return the ids of the arcs through which node i reads node j; none if they are not linked."""
        i, j = indices("nodes", [i, j], (2,), self.n_nodes, AssumptionError).tolist()
        first, last = self.indptr[i], self.indptr[i + 1]
        return first + np.flatnonzero(self.indices[first:last] == j)

    def arcs_along(self, nodes: Ints) -> Ints:
        """Return the ids (k - 1,) of the arcs through which each of ``nodes`` (k,) reads the next one.

        The first of parallel arcs counts. Raises :class:`AssumptionError` where two nodes are not linked.
        """
        nodes = indices("nodes", nodes, ("k",), self.n_nodes, AssumptionError)
        tails, heads = nodes[:-1], nodes[1:]
        counts = np.diff(self.indptr)[tails]
        arcs, step = ranges(self.indptr[tails], counts), np.repeat(np.arange(len(tails)), counts)
        there = np.flatnonzero(self.indices[arcs] == heads[step])
        linked, rows = np.unique(step[there], return_index=True)
        if len(linked) < len(tails):
            lost = int(np.setdiff1d(np.arange(len(tails)), linked)[0])
            raise AssumptionError(f"node {tails[lost]} does not read node {heads[lost]}: give the nodes of a path.")
        return arcs[there[rows]]

    def without_arcs(self, arcs: Ints) -> Network:
        """Return the network without these arc ids; the ids of later arcs move down."""
        keep = np.ones(self.n_arcs, dtype=bool)
        keep[indices("arcs", arcs, ("k",), self.n_arcs, AssumptionError)] = False
        arc_cost = None if self.arc_cost is None else self.arc_cost[keep]
        indptr = cumulative_sums(keep)[self.indptr]
        return replace(self, indptr=indptr, indices=self.indices[keep], weight=self.weight[keep], arc_cost=arc_cost)
