"""Networks that the tests of this folder share."""

from __future__ import annotations

from typing import Any

import numpy as np

from planner import gabf

# Tests hand in lists and know which results are there; a type checker would ask for both to be said each time.
solve: Any = gabf.solve
Network: Any = gabf.Network


def from_arcs(n, arcs, sources=(0,), **more):
    """A network from a list of (i, j, weight), in any order."""
    arcs = sorted(arcs, key=lambda arc: arc[0])
    tails = np.array([i for i, _, _ in arcs], dtype=np.int64)
    indptr = np.concatenate(([0], np.cumsum(np.bincount(tails, minlength=n))))
    more.setdefault("kernel", gabf.Additive())
    heads = np.array([j for _, j, _ in arcs], dtype=np.int64)
    weight = np.array([w for _, _, w in arcs], dtype=float)
    return Network(indptr, heads, weight, sources=np.array(sources), **more)


def chain(n, cost=1.0, **more):
    """Node i reads node i - 1; the source is node 0, so x_i* = i cost."""
    return from_arcs(n, [(i, i - 1, cost) for i in range(1, n)], **more)


def scattered(n, seed=0, degree=4, **more):
    """Nodes in the unit square, each linked in both directions to its nearest neighbours; may be in several pieces."""
    rng = np.random.default_rng(seed)
    points = rng.random((n, 2)) * np.sqrt(n)
    length = np.linalg.norm(points[:, None] - points[None], axis=2)
    near = np.argsort(length, axis=1)[:, 1 : degree + 1]
    pairs = {(min(i, j), max(i, j)) for i in range(n) for j in near[i]}
    arcs = [(i, j, length[i, j]) for a, b in pairs for i, j in ((a, b), (b, a))]
    more.setdefault("kernel", gabf.TradeOff(beta=0.5))
    more.setdefault("node_cost", rng.random(n) * 0.9 + 0.1)
    return from_arcs(n, arcs, **more)


def path_cost(net, path):
    """The cost of a path by the kernel itself, cheapest of parallel arcs."""
    anchors = dict(zip(net.sources.tolist(), net.source_values.tolist(), strict=True))
    cost = anchors[int(path[-1])]
    for i, j in zip(path[-2::-1], path[:0:-1], strict=True):
        arcs = net.arcs_between(i, j)
        cost = float(net.arcs.take(arcs)(np.full(arcs.size, cost)).min())
    return cost


def require_paths(net, result):
    """From every node that reaches a source the extracted path costs x_i, ends at a source and repeats no node."""
    for start in np.flatnonzero(np.isfinite(result.x)):
        path = gabf.extract_path(net, result, int(start))
        assert path[0] == start
        assert path[-1] in net.sources
        assert np.unique(path).size == path.size
        assert path_cost(net, path) == result.x[start]
