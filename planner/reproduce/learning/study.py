"""One graph of the paper's third simulation: both rules, stage by stage, and everything that is measured on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from planner import gabf, learning
from planner.base.arrays import Ints
from planner.learning import ErrorDriven, Hebbian, LearningRule, Stage
from planner.reproduce.learning.graphs import START, GridGraph, distances, draw_grid
from planner.reproduce.learning.threshold import PRECISION, Threshold, threshold
from planner.reproduce.report import or_infinite

T_P = 4.0
"""The prescribed time of every planning stage, s, as in section (comparison)."""

SOON = 0.05
"""Another prescribed time, s, to see that the user may set it."""

NEARLY_ONE = 0.9999
"""A start above every x_i* here, inside the kernel's domain a < 1."""

IN_TURN = 10
"""Graphs on which arcs are also trained one after another, which takes a hundred times as many planning stages."""

HEBBIAN, ERROR_DRIVEN = Hebbian(), ErrorDriven()
RULES: tuple[LearningRule, ...] = (HEBBIAN, ERROR_DRIVEN)


@dataclass(frozen=True)
class StageFacts:
    """One planning stage in numbers.

    ``optimal``: the path is the Euclidean shortest one; ``excess``: by what share it is longer, ``hops`` its arcs.
    ``off_target``: the median over arcs of |wbar - (1 - beta d)|; ``wbar_min``, ``wbar_max`` the extreme weights,
    ``correlation`` that of weights and distances, 0 where all weights are equal; ``zeta`` that of eq. (progressive).
    ``settling_time`` s, +inf where it did not settle; ``warm_tau`` and ``cold_tau`` the settling tau from the current x
    and from 0; ``oracle_error`` max |x - x*| against an algorithm that never integrates; ``product_error`` max over
    nodes of the difference between -ln(1 - x) and the least sum of -ln wbar that SciPy finds; ``path_error`` that
    between 1 - x and the product along the path, in relation.
    """

    iteration: int
    optimal: bool
    excess: float
    hops: int
    off_target: float
    wbar_min: float
    wbar_max: float
    correlation: float
    zeta: float
    settling_time: float
    warm_tau: float
    cold_tau: float
    oracle_error: float
    product_error: float
    path_error: float


@dataclass(frozen=True, eq=False)
class TrainingRun:
    """One rule on one graph: its planning stages from before the first training iteration on, and their numbers."""

    rule: LearningRule
    stages: tuple[Stage, ...]
    facts: tuple[StageFacts, ...]


def train(graph: GridGraph, rule: LearningRule, iterations: int) -> TrainingRun:
    """Learn all arcs at once for ``iterations``, every stage under the singularity-free law."""
    stages = learning.learn(graph.network, rule, graph.d, iterations, law=gabf.SingularityFree(T=T_P))
    return TrainingRun(rule, stages, tuple(_facts(graph, rule, stage) for stage in stages))


def _facts(graph: GridGraph, rule: LearningRule, stage: Stage) -> StageFacts:
    path, field = stage.path(START), stage.field
    additive = distances(stage.network, -np.log(stage.wbar))
    product = float(stage.wbar[stage.network.arcs_along(path)].prod())
    return StageFacts(
        iteration=stage.iteration,
        optimal=graph.is_shortest(path),
        excess=graph.length(path) / graph.shortest_length - 1.0,
        hops=len(path) - 1,
        off_target=float(np.median(np.abs(stage.wbar - (1.0 - rule.beta * graph.d)))),
        wbar_min=float(stage.wbar.min()),
        wbar_max=float(stage.wbar.max()),
        correlation=float(np.corrcoef(stage.wbar, graph.d)[0, 1]) if np.ptp(stage.wbar) > 0.0 else 0.0,
        zeta=field.premises.zeta,
        settling_time=or_infinite(field.settling_time),
        warm_tau=or_infinite(field.settling_tau),
        cold_tau=or_infinite(learning.planning_stage(stage.network, law=field.law).field.settling_tau),
        oracle_error=gabf.max_error(field, gabf.oracle(stage.network)),
        product_error=float(np.abs(np.log1p(-field.x) + additive).max()),
        path_error=abs((1.0 - field.x[START]) / product - 1.0),
    )


@dataclass(frozen=True)
class RuleFacts:
    """What the text says of the rules, on one graph's first training iteration.

    ``equal_activity``: at one activity the shorter arc has the larger update, in every pair of arcs; ``concordant``:
    the share of pairs in which it has as the rule acts, at the activities that the arcs have.
    ``first_outside``: the training iteration after which the rule to the letter has a weight outside (0, 1), 0 where it
    has none in ``tried`` iterations; ``fast_outside`` the same at the learning rate of the error-driven rule.
    """

    equal_activity: bool
    concordant: float
    first_outside: int
    fast_outside: int
    tried: int


def rule_facts(graph: GridGraph, rule: Hebbian, iterations: int) -> RuleFacts:
    """Look at the Hebbian rule as printed."""
    stage = learning.planning_stage(graph.network)
    a, ends = stage.activity, (graph.network.tails, graph.network.indices)
    ones = np.ones_like(graph.d)
    level = rule.unbounded(0.0 * ones, ones, ones, graph.d)
    update = rule.unbounded(0.0 * ones, a[ends[0]], a[ends[1]], graph.d)
    one, other = np.triu_indices(graph.d.size, 1)
    differ = graph.d[one] != graph.d[other]
    shorter = np.sign(graph.d[other] - graph.d[one])[differ]
    return RuleFacts(
        equal_activity=bool((shorter * (level[one] - level[other])[differ] > 0.0).all()),
        concordant=float((shorter * (update[one] - update[other])[differ] > 0.0).mean()),
        first_outside=_first_outside(stage, rule, graph, iterations),
        fast_outside=_first_outside(stage, replace(rule, alpha=ERROR_DRIVEN.alpha), graph, iterations),
        tried=iterations,
    )


def _first_outside(stage: Stage, rule: Hebbian, graph: GridGraph, iterations: int) -> int:
    for k in range(1, iterations + 1):
        a = stage.activity
        free = rule.unbounded(stage.wbar, a[stage.network.tails], a[stage.network.indices], graph.d)
        if not ((free > 0.0) & (free < 1.0)).all():
            return k
        stage = learning.next_stage(stage, rule, graph.d)
    return 0


@dataclass(frozen=True)
class LawFacts:
    """The law without knowledge of the graph, on untrained weights.

    ``runs``: (T_p, x_i(0), settling time) of each, s. ``sweeps``: synchronous Bellman-Ford sweeps from 0.9999 to x*.
    """

    runs: tuple[tuple[float, float, float], ...]
    sweeps: int

    @property
    def in_time(self) -> bool:
        """Every run settled before its own T_p."""
        return all(settled < T for T, _, settled in self.runs)


def law_facts(network: gabf.Network) -> LawFacts:
    """Settle under one law for every graph, for two prescribed times, from below and from above x*."""
    runs = [
        (T, x0, or_infinite(gabf.solve(network, law=gabf.SingularityFree(T=T), x0=x0).settling_time))
        for T in (SOON, T_P)
        for x0 in (0.0, NEARLY_ONE)
    ]
    sweeps = gabf.value_iteration(network, np.full(network.n_nodes, NEARLY_ONE))[1]
    return LawFacts(tuple(runs), sweeps)


@dataclass(frozen=True)
class LargeK:
    """Whether GABF's path under wbar = 1 - w / K is the Euclidean shortest one, for three values of K.

    These are the proved bound, and ``margin`` above and below the smallest K. ``below`` is None where only the longest
    arc keeps K from being smaller.
    """

    at_bound: bool
    above: bool
    below: bool | None


def large_k(graph: GridGraph, found: Threshold) -> LargeK:
    """Run GABF at the two ends that :func:`threshold` found by other means."""
    low = found.smallest * (1.0 - PRECISION)
    return LargeK(
        at_bound=_shortest_at(graph, found.bound * (1.0 + 1e-9)),
        above=_shortest_at(graph, found.smallest * (1.0 + PRECISION)),
        below=_shortest_at(graph, low) if low > found.longest else None,
    )


def _shortest_at(graph: GridGraph, K: float) -> bool:
    network = replace(graph.network, weight=graph.d, kernel=gabf.Multiplicative(K))
    field = gabf.solve(network, law=gabf.SingularityFree(T=T_P), x0=0.0)
    return graph.is_shortest(gabf.extract_path(network, field, START))


@dataclass(frozen=True)
class InTurn:
    """All arcs at once against one arc after another, on one graph: whether each one's path is optimal, by iteration.

    In turn by the order of the nodes, which begins at the start, or ``outwards`` from the goal, where activity comes
    from. ``solves``: planning stages an iteration of :func:`planner.learning.learn_in_turn`; at once it is 1.
    """

    at_once: tuple[bool, ...]
    by_node: tuple[bool, ...]
    outwards: tuple[bool, ...]
    solves: int


def compare_in_turn(graph: GridGraph, run: TrainingRun) -> InTurn:
    """Train the arcs one after another as often as ``run`` trained them at once."""
    network, iterations = graph.network, len(run.stages) - 1
    nearest_first = np.argsort(-run.stages[0].activity[network.indices], kind="stable")

    def in_turn(order: Ints) -> tuple[bool, ...]:
        law = gabf.SingularityFree(T=T_P)
        stages = learning.learn_in_turn(network, run.rule, graph.d, iterations, law, order)
        return tuple(graph.is_shortest(stage.path(START)) for stage in stages)

    at_once = tuple(facts.optimal for facts in run.facts)
    return InTurn(at_once, in_turn(np.arange(network.n_arcs)), in_turn(nearest_first), network.n_arcs)


@dataclass(frozen=True, eq=False)
class GraphStudy:
    """Everything measured on one graph; ``runs`` by the rule's name, ``in_turn`` on the first few graphs only."""

    graph: GridGraph
    threshold: Threshold
    large_k: LargeK
    runs: dict[str, TrainingRun]
    rule: RuleFacts
    law: LawFacts
    in_turn: InTurn | None

    def facts(self, rule: LearningRule) -> tuple[StageFacts, ...]:
        """The stages of one rule, from before the first training iteration on."""
        return self.runs[rule.name].facts

    @property
    def stages(self) -> list[StageFacts]:
        """All stages of all rules."""
        return [facts for run in self.runs.values() for facts in run.facts]

    @property
    def trained(self) -> list[StageFacts]:
        """The stages after a training iteration."""
        return [facts for facts in self.stages if facts.iteration > 0]

    def always(self, holds: Callable[[StageFacts], bool]) -> bool:
        """Whether something holds at every stage."""
        return all(map(holds, self.stages))


def study_graph(k: int, iterations: int, seed: int) -> GraphStudy:
    """Everything about graph k of a seed."""
    graph = draw_grid(np.random.default_rng([seed, 0, k]))
    found = threshold(graph)
    runs = {rule.name: train(graph, rule, iterations) for rule in RULES}
    return GraphStudy(
        graph=graph,
        threshold=found,
        large_k=large_k(graph, found),
        runs=runs,
        rule=rule_facts(graph, HEBBIAN, iterations),
        law=law_facts(graph.network),
        in_turn=compare_in_turn(graph, runs[ERROR_DRIVEN.name]) if k < IN_TURN else None,
    )
