"""The structure of the optimum, without an ODE: true parents, longest optimal paths, levels, effective diameter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen, indices
from planner.gabf.network import Network
from planner.gabf.oracle import oracle
from planner.gabf.problem import Problem, reduce, states

TIES = 1e-12  # times max(1, |x*|), 1 less where all x* are: paths whose costs differ by less are tied, as they round


@dataclass(frozen=True, eq=False)
class Structure:
    """What definitions (true), (longest) and (S) name; arrays over the n nodes, -1 where a node reaches no source.

    ``x_star`` (n,); ``true_arcs`` ids of the arcs (i, j) with j in P(i); ``longest`` the l of F_l; ``fewest``
    arcs on the optimal path of fewest hops (ours); ``level`` the l of S_l; ``values`` (R + 1,) the distinct
    xbar_l*, the sources' smallest value first; ``diameter`` D(G) in nodes, so that 6 -> 8 -> 9 counts three.
    """

    x_star: Floats
    true_arcs: Ints
    longest: Ints
    fewest: Ints
    level: Ints
    values: Floats
    diameter: int
    unreachable: Ints

    def __post_init__(self) -> None:
        for name, value in list(vars(self).items()):
            if isinstance(value, np.ndarray):
                object.__setattr__(self, name, frozen(value, value.dtype))

    @property
    def R(self) -> int:
        """The number of levels, R of definition (S)."""
        return self.values.size - 1


def structure(net: Network, x_star: Floats | None = None) -> Structure:
    """Everything about the optimum of any progressive increasing kernel.

    ``x_star``: the oracle's unless given. Parents and hops count costs as tied that differ by at most
    1e-12 max(1, |x*|), with the largest |x*| in place of 1 where that is less. Levels count every distinct x*: a chain
    of tiny arcs settles one after another, however near its values are.
    """
    x = oracle(net) if x_star is None else states(net, x_star, "x_star")
    problem = reduce(net)
    y = problem.pack(x)
    tight = _true_arcs(problem, y)
    longest, fewest = _most_hops(problem, tight, y), problem.hops_along(tight)
    level, values = _levels(problem, y)
    level = problem.unpack(level, missing=-1)
    return Structure(
        x_star=x,
        true_arcs=problem.arc_ids[tight],
        longest=problem.unpack(longest, missing=-1),
        fewest=problem.unpack(np.where(fewest < 0, problem.nodes.size, fewest), missing=-1),
        level=level,
        values=values,
        diameter=int(longest.max(initial=0)) + 1,
        unreachable=np.flatnonzero(level < 0),
    )


def true_parents(net: Network, optimum: Structure, i: int) -> Ints:
    """P(i), definition (true), ascending; empty at sources and at nodes that reach none.

    Raises :class:`ArrayError` where there is no node ``i``.
    """
    i = int(indices("i", i, (), net.n_nodes))
    arcs = optimum.true_arcs
    return np.unique(net.indices[arcs[net.tails[arcs] == i]])


def _true_arcs(problem: Problem, y: Floats) -> Bools:
    """Arcs with f_i(x_j*, w_ij) = x_i*, and x_j* < x_i*, so that no cycle of ties is let in."""
    values, own, head = problem.arcs(y[problem.heads]), y[problem.owners], y[problem.heads]
    nearly = TIES * np.maximum(min(1.0, float(np.abs(y).max(initial=0.0))), np.abs(own))
    return (values <= own + nearly) & (head < own)


def _most_hops(problem: Problem, tight: Bools, y: Floats) -> Ints:
    """The most true arcs from each node to a source; these lead to smaller x*, so one pass in that order suffices."""
    owners, heads = problem.owners[tight], problem.heads[tight]
    order = np.argsort(y[owners], kind="stable")
    hops = [0] * problem.nodes.size
    for owner, head in zip(owners[order].tolist(), heads[order].tolist(), strict=True):
        hops[owner] = max(hops[owner], hops[head] + 1)
    return np.array(hops, dtype=np.int64)


def _levels(problem: Problem, y: Floats) -> tuple[Ints, Floats]:
    """The l of S_l for every node, and the values; all sources are S_0."""
    values, rank = np.unique(y[: problem.n_rows], return_inverse=True)
    level = np.zeros(problem.nodes.size, dtype=np.int64)
    level[: problem.n_rows] = rank + 1
    return level, np.concatenate(([problem.anchors.min()], values))
