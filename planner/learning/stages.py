"""Planning and training alternately: GABF settles x on the current weights, then x trains the weights."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.learning.rules import LearningRule

FIRST_WEIGHT = 0.5
"""The paper's initial value of every wbar_ij."""

FIRST_STATE = 0.0
"""x_i(0) of the first planning stage: a number that asks for no knowledge of the graph, below every x_i*."""


@dataclass(frozen=True, eq=False)
class Stage:
    """A planning stage: the network with the weights wbar_ij as they were, and the field that GABF settled on them.

    ``iteration`` counts the training iterations before it. Where every weight is in (0, 1), as the learning rules
    leave them, eq. (wb) is progressive on what a run sees: x stays in [x_low, x_high] with x_high < 1, because
    f(a) = 1 - (1 - a) wbar < 1 for a < 1, and there f(a) - a = (1 - a)(1 - wbar) >= (1 - x_high)(1 - max wbar) > 0.
    ``field.premises`` holds these numbers.
    """

    iteration: int
    network: gabf.Network
    field: gabf.CostToGo

    @property
    def wbar(self) -> Floats:
        """(n_arcs,) the weights."""
        return self.network.weight

    @property
    def activity(self) -> Floats:
        """(n,) 1 - x_i: the largest product of weights along a path to a source; 0 where there is no path."""
        x = self.field.x
        return np.where(np.isfinite(x), 1.0 - x, 0.0)

    def path(self, start: int) -> Ints:
        """Nodes from ``start`` to a source along minimising neighbours."""
        return gabf.extract_path(self.network, self.field, start)


def untrained(tails: Ints, heads: Ints, sources: Ints, n_nodes: int, wbar: float = FIRST_WEIGHT) -> gabf.Network:
    """The network of eq. (wb) before learning, of arcs (tails[k], heads[k]): every weight ``wbar`` in (0, 1).

    On paths of more than 50 arcs of weight 0.5 x rounds to 1 and a planning stage raises AssumptionError: begin with
    weights nearer 1 there.
    """
    weight = np.full(len(heads), wbar)
    return gabf.Network.from_arcs(tails, heads, weight, sources, n_nodes, kernel=gabf.Multiplicative())


def planning_stage(
    network: gabf.Network, x0: Floats | float = FIRST_STATE, law: gabf.Law | None = None, iteration: int = 0
) -> Stage:
    """Settle x by GABF from ``x0``, under the singularity-free law unless another is given."""
    return Stage(iteration, network, gabf.solve(network, law=law, x0=x0))


def trained(stage: Stage, rule: LearningRule, d: Floats, arcs: Ints | None = None) -> gabf.Network:
    """The network after one training iteration: each arc by the activities at its own two ends, all at once.

    ``d`` (n_arcs,) distances (or costs, where known); ``arcs``: ids of the arcs that are trained, all where left out.
    """
    network, activity = stage.network, stage.activity
    ids = np.arange(network.n_arcs) if arcs is None else arcs
    ends = activity[network.tails[ids]], activity[network.indices[ids]]
    weight = network.weight.copy()
    weight[ids] = rule.updated(weight[ids], *ends, d[ids])
    return replace(network, weight=weight)


def next_stage(stage: Stage, rule: LearningRule, d: Floats, arcs: Ints | None = None) -> Stage:
    """Train once and settle x again, warm from the current x, under the same law."""
    network = trained(stage, rule, d, arcs)
    return planning_stage(network, stage.field.x, stage.field.law, stage.iteration + 1)


def learn(
    network: gabf.Network, rule: LearningRule, d: Floats, iterations: int, law: gabf.Law | None = None
) -> tuple[Stage, ...]:
    """The ``iterations`` + 1 planning stages before and after each training iteration of all arcs at once.

    stages = learn(untrained(tails, heads, sources, n), ErrorDriven(), d, iterations=6)
    stages[-1].path(start)
    """
    stages = [planning_stage(network, law=law)]
    for _ in range(iterations):
        stages.append(next_stage(stages[-1], rule, d))
    return tuple(stages)


def learn_in_turn(
    network: gabf.Network,
    rule: LearningRule,
    d: Floats,
    iterations: int,
    law: gabf.Law | None = None,
    order: Ints | None = None,
) -> tuple[Stage, ...]:
    """As :func:`learn`, one arc after another in ``order`` (arc ids, ascending if not given), x settled after each.

    Takes n_arcs planning stages an iteration where :func:`learn` takes one.
    """
    turns = np.arange(network.n_arcs) if order is None else order
    stages = [planning_stage(network, law=law)]
    for k in range(iterations):
        stage = stages[-1]
        for arc in turns:
            stage = next_stage(stage, rule, d, np.array([arc]))
        stages.append(replace(stage, iteration=k + 1))
    return tuple(stages)
