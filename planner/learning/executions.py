"""Learning costs by paying them: each execution of a path reveals what its arcs, and the arcs beside them, cost.

The planner does not know the cost c_ij of an arc until a path comes past it. It believes a cost b_ij, kept as the
weight wbar_ij = 1 - beta b_ij, plans by GABF on its beliefs, executes the path, and trains the weights of every arc
that touches the path (the error-driven rule with c_ij for d_ij, all of them at once). It explores only by what it
believes of arcs it has not seen:

- *optimistic*, b <= c: it tries what might be better. Where the gain min(1, alpha (1 - x_i)(1 - x_j)) is 1 at all
  arcs seen, at most n / 2 executions of a network of n nodes can cost more than the optimum plus
  :func:`planner.learning.excess_bound`, whatever their starts. For if a path has no arc that is seen for the first
  time, its cost is what it was believed to be, which no path undercuts in belief (but for that bound), the optimal
  one included, whose belief is at most its cost. And if it has one, neither end of that arc had been visited before,
  since a visit shows every arc at a node: such an execution visits two nodes or more for the first time.
- *pessimistic*, b >= c: what it has not seen looks costly, so it keeps to the first path that is good enough.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.learning.rules import ErrorDriven
from planner.learning.stages import Stage, next_stage, planning_stage


@dataclass(frozen=True, eq=False)
class Execution:
    """One execution: the ``stage`` that it was planned on, ``path`` (k,) nodes, ``cost`` as it turned out.

    ``seen``: ids of the arcs whose costs it revealed, those that touch a node of the path.
    """

    stage: Stage
    path: Ints
    cost: float
    seen: Ints


def believed(network: gabf.Network, rule: ErrorDriven, costs: Floats) -> gabf.Network:
    """The network whose weights say that the arcs cost ``costs`` (n_arcs,), each below 1 / beta."""
    return replace(network, weight=rule.target(costs), kernel=gabf.Multiplicative())


def execute(stage: Stage, costs: Floats, start: int) -> Execution:
    """Follow the field from ``start`` to a source and pay ``costs`` (n_arcs,) arc by arc."""
    path = stage.path(start)
    pairs = itertools.pairwise(path.tolist())
    paid = sum(float(costs[stage.network.arcs_between(i, j)].min()) for i, j in pairs)
    return Execution(stage, path, paid, touching(stage.network, path))


def touching(network: gabf.Network, nodes: Ints) -> Ints:
    """Ids of the arcs that begin or end at one of ``nodes``."""
    near = np.zeros(network.n_nodes, dtype=bool)
    near[nodes] = True
    return np.flatnonzero(near[network.tails] | near[network.indices])


def run_executions(
    beliefs: gabf.Network, costs: Floats, rule: ErrorDriven, starts: Iterable[int]
) -> Iterator[Execution]:
    """One execution a start, each planned on what the ones before it have taught; x goes on from the last x.

    ``beliefs``: a network of :func:`believed`. ``costs`` (n_arcs,) true costs, read at revealed arcs only. No parallel
    arcs: their weights would be trained apart and the path could not say which one it took.
    """
    stage = planning_stage(beliefs)
    for start in starts:
        done = execute(stage, costs, start)
        yield done
        after = next_stage(stage, rule, costs, done.seen)
        stage = stage if np.array_equal(after.wbar, stage.wbar) else after


def policy_cost(stage: Stage, costs: Floats) -> Floats:
    """(n,) what following the field from each node would cost in truth; +inf at nodes that reach no source.

    Of several minimising neighbours one stands for all.
    """
    network, x = stage.network, stage.field.x
    head = x[network.indices]
    values = np.where(np.isfinite(head), network.arcs(np.where(np.isfinite(head), head, 0.0)), np.inf)
    arcs = np.lexsort((values, network.tails))
    owners, first = np.unique(network.tails[arcs], return_index=True)
    chosen = np.full(network.n_nodes, -1)
    chosen[owners] = arcs[first]
    total = np.full(network.n_nodes, np.inf)
    total[network.sources] = 0.0
    # ascending x: eq. (progressive) puts the neighbour that is followed before the node itself
    for i in np.argsort(x, kind="stable")[: np.isfinite(x).sum()].tolist():
        if total[i] == np.inf:
            total[i] = total[network.indices[chosen[i]]] + costs[chosen[i]]
    return total
