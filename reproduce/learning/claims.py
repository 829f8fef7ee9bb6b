"""The sentences of the section on learning-based path planning, and their checks on one graph."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from operator import attrgetter

import numpy as np

from planner import gabf
from planner.base.errors import AssumptionError
from planner.gabf.learning import FIRST_WEIGHT, LearningRule
from reproduce.learning.study import ERROR_DRIVEN, HEBBIAN, SOON, T_P, GraphStudy, StageFacts
from reproduce.report import Claim

ROUNDING = 1e-9
"""Rounding of x near 1 in -ln(1 - x), where activities are as small as 1e-4."""

CLOSE = 0.01
"""Trained weights "approximate" 1 - w / K if half of them are this close to it, in units of 1 / K."""


def link(weight: float, K: float | None = None) -> gabf.Network:
    """One node that reads one source."""
    indptr, indices = np.array([0, 0, 1]), np.array([0])
    return gabf.Network(indptr, indices, np.array([weight]), np.array([0]), kernel=gabf.Multiplicative(K))


def margin(end: float) -> float:
    """The zeta of eq. (wb) with wbar = 0.5 for a in [0, end]."""
    return float(link(FIRST_WEIGHT).arcs.extremes(0.0, end)[0][0])


def _maps_into_unit_interval(weight: float) -> bool:
    try:
        link(weight, K=1.0)
    except AssumptionError:
        return False
    return True


KERNEL: tuple[Claim[float], ...] = (  # of one weight, with K = 1
    Claim(
        "f_i maps R_[0,1) x R_>0 into R_(0,1).",
        _maps_into_unit_interval,
        "with w = 2 K, f(a) = 2 - a > 1, falling in a: it needs w < K, and the planner refuses others",
    ),
    Claim(
        "f_i satisfies the progressive property (one zeta > 0 for every a in [0, 1)).",
        lambda _: margin(1.0) > 0.0,
        "f(a) - a = (1 - a)(1 - wbar) vanishes as a reaches 1: with wbar = 0.5 zeta up to a = 0.9 is {:.1g}, up to "
        "1 - 1e-8 {:.1g}",
        (lambda _: margin(0.9), lambda _: margin(1.0 - 1e-8)),
    ),
)


def _of_stages(quantity: Callable[[StageFacts], float]) -> Callable[[GraphStudy], Iterable[float]]:
    return lambda graph: map(quantity, graph.all_facts)


def _of_trained(quantity: Callable[[StageFacts], float]) -> Callable[[GraphStudy], list[float]]:
    return lambda graph: [quantity(facts) for facts in graph.all_facts if facts.iteration > 0]


FIELD: tuple[Claim[GraphStudy], ...] = (
    Claim(
        f"The resulting path remains the shortest path for node i when K is sufficiently large (K = "
        f"{1.0 / ERROR_DRIVEN.beta:g}).",
        lambda graph: graph.shortest_at_large_K,
        "the smallest such K grows as the second-shortest path becomes as short, so no K serves all graphs",
    ),
    Claim(
        "(ours) f_i is progressive and increasing on the states of each run, all weights being in (0, 1).",
        lambda graph: graph.always(lambda f: f.wbar_min > 0.0 and f.wbar_max < 1.0 and f.zeta > 0.0),
        "zeta {}",
        (_of_stages(attrgetter("zeta")),),
    ),
    Claim(
        "x_i(t) can be directly incorporated into the learning process (1 - x_i is the product of the weights).",
        lambda graph: graph.always(lambda facts: facts.path_error <= ROUNDING),
        "relative difference {:.2g}",
        (_of_stages(attrgetter("path_error")),),
    ),
    Claim(
        "(ours) Eq. (wb) is additive under -ln(1 - x): SciPy's Dijkstra on -ln wbar finds the same field.",
        lambda graph: graph.always(lambda facts: facts.product_error <= ROUNDING),
        "largest difference over the nodes {:.2g}",
        (_of_stages(attrgetter("product_error")),),
    ),
    Claim(
        "The resulting wbar_ij can facilitate the computation (from the last x it settles sooner than from 0).",
        lambda graph: sum(_of_trained(attrgetter("warm_tau"))(graph)) < sum(_of_trained(attrgetter("cold_tau"))(graph)),
        "settling tau of a stage {} from the last x, {} from 0",
        (_of_trained(attrgetter("warm_tau")), _of_trained(attrgetter("cold_tau"))),
    ),
    Claim(
        "The law ensures convergence within a user-defined time, in a knowledge-free sense.",
        lambda graph: max(graph.soon) < SOON and graph.always(lambda facts: facts.settling_time < T_P),
        f"one set of parameters and x(0) = 0 for all graphs: settled at t = {{}} s of T_p = {T_P:g} s; with T_p = "
        f"{SOON:g} s at {{}} s, from below and from above x*",
        (_of_stages(attrgetter("settling_time")), lambda graph: graph.soon),
    ),
    Claim(
        "The modified Bellman-Ford algorithm requires prior knowledge of the graph (to know when it may stop).",
        lambda graph: graph.sweeps < graph.graph.network.n_nodes - 1,
        "{:.0f} sweeps from above settle x; certainty without knowledge of the graph takes one per node",
        (lambda graph: graph.sweeps,),
    ),
)

RULE: tuple[Claim[GraphStudy], ...] = (
    Claim(
        "Smaller distances lead to larger reward values and larger weight updates (at equal activity).",
        lambda graph: graph.rule.equal_activity,
        "R = 1 - beta d falls in d for any beta > 0",
    ),
    Claim(
        "... larger weight updates (as the rule acts, at the activities that the arcs have).",
        lambda graph: graph.rule.concordant == 1.0,
        "of two arcs the shorter one has the larger update in {} of all pairs: the activity, at first 0.5 to the power "
        "of the hops, decides, and not the distance",
        (lambda graph: graph.rule.concordant,),
    ),
    Claim(
        f"(ours) The rule as printed keeps every wbar_ij in (0, 1) ({HEBBIAN.label}).",
        lambda graph: graph.rule.first_outside == 0,
        f"weights only grow while beta d < 1, and are held at {HEBBIAN.ceiling:g} here; elsewhere one leaves (0, 1) "
        "after iteration {:.0f}",
        (lambda graph: [graph.rule.first_outside] if graph.rule.first_outside else [],),
    ),
)


def _at_once(graph: GraphStudy) -> bool:
    turn = graph.in_turn
    return turn is not None and turn.at_once[-1] >= max(turn.by_node[-1], turn.outwards[-1])


IN_TURN: tuple[Claim[GraphStudy], ...] = (
    Claim(
        "GABF enables simultaneous training of each wbar_ij, in contrast to sequential training.",
        _at_once,
        "planning stages per iteration 1 at once, {:.0f} in turn, and no fewer shortest paths at the end",
        (lambda graph: graph.in_turn.solves if graph.in_turn else (),),
    ),
)

DRAWN: tuple[Claim[bool], ...] = (
    Claim("(ours) A graph as described has a path from every node (counts are of drawn graphs).", lambda drawn: drawn),
)


def simulation(rule: LearningRule, iterations: int) -> Iterator[Claim[GraphStudy]]:
    """The sentences on fig. (learning), for one rule; iterations that were not run are not judged."""
    name = f"({rule.label})"

    def at(k: int, quantity: Callable[[StageFacts], float]) -> Callable[[GraphStudy], float]:
        return lambda graph: quantity(graph.facts[rule.name][k])

    def excess(k: int) -> Callable[[GraphStudy], float]:
        return at(k, lambda facts: 100.0 * facts.excess)

    def improved(k: int) -> Callable[[GraphStudy], bool]:
        return lambda graph: excess(k)(graph) < excess(1)(graph) and not graph.facts[rule.name][k].optimal

    longer = "longer than the shortest by {:.2g} %"
    yield Claim(
        f"The trained weights wbar_ij approximate 1 - w_ij / K {name}.",
        lambda graph: graph.facts[rule.name][-1].off_target <= CLOSE * rule.beta,
        "after the last iteration the median |wbar - (1 - beta d)| is {} beta; correlation of weights with distances "
        "{:.2f}",
        (at(-1, lambda facts: facts.off_target / rule.beta), at(-1, attrgetter("correlation"))),
    )
    yield Claim(
        f"After the initial training, GABF produces a feasible but suboptimal path {name}.",
        lambda graph: not graph.facts[rule.name][1].optimal,
        f"every path is feasible; {longer}",
        (excess(1),),
    )
    for k, source in ((2, "as the text says"), (3, "as the figure says")):
        if k <= iterations:
            yield Claim(
                f"After {k} training iterations ({source}) the path is improved but still non-optimal {name}.",
                improved(k),
                longer,
                (excess(k),),
            )
    sixth = "the sixth" if iterations == 6 else f"the last ({iterations})"
    yield Claim(
        f"After {sixth} training iteration, GABF identifies and converges to the shortest path {name}.",
        lambda graph: graph.facts[rule.name][-1].optimal,
        longer,
        (excess(-1),),
    )
