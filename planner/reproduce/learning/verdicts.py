"""The section on learning-based path planning sentence by sentence: confirmed or not, on how many graphs, by what."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner import gabf
from planner.base.errors import AssumptionError
from planner.learning import FIRST_WEIGHT, LearningRule
from planner.reproduce.learning.study import ERROR_DRIVEN, HEBBIAN, RULES, SOON, T_P, GraphStudy, StageFacts
from planner.reproduce.learning.threshold import PRECISION
from planner.reproduce.report import Verdict, spread, tally

ROUNDING = 1e-9
"""What -ln(1 - x) and the additive cost may differ by: rounding of x near 1, where activities are as small as 1e-4."""

SIDE = 1.0
"""The side of the square, a K that one might think of."""

CLOSE = 0.01
"""Trained weights "approximate" 1 - w / K if half of them are this close to it, in units of 1 / K."""


def learning_verdicts(studies: Sequence[GraphStudy]) -> tuple[Verdict, ...]:
    """Every sentence of the section; counts are of graphs unless there is but one case."""
    if not studies:
        return ()
    found = [*kernel_verdicts(studies), *_rule(studies), *_at_once(studies)]
    for rule in RULES:
        found += _simulation(studies, rule)
    redraws = sum(study.graph.redraws for study in studies)
    connected = tally(
        "(ours) A graph as described has a path from every node (counts are of drawn graphs).",
        [True] * len(studies) + [False] * redraws,
        f"the others were thrown away; {spread((s.graph.d.size / 2 for s in studies), '.0f')} links; the offset moves "
        f"{spread((study.graph.outside for study in studies), '.0f')} of the 36 nodes out of [0,1] x [0,1]",
    )
    return (*found, connected)


def shares(studies: Sequence[GraphStudy], rule: LearningRule) -> list[float]:
    """The share of graphs with the shortest path at each stage of a rule."""
    return _means([[facts.optimal for facts in study.facts(rule)] for study in studies])


def _means(runs: Sequence[Sequence[bool]]) -> list[float]:
    """The share of True at each place, over the runs."""
    return np.array(runs, dtype=float).mean(axis=0).tolist() if runs else []


def kernel_verdicts(studies: Sequence[GraphStudy]) -> list[Verdict]:
    """The sentences on large K, on the kernel's properties, on x in the learning process and on the law."""
    return [*_large_k(studies), *_properties(studies), *_field(studies), *_law(studies)]


def _large_k(studies: Sequence[GraphStudy]) -> list[Verdict]:
    found, beta = [study.threshold for study in studies], ERROR_DRIVEN.beta
    ratio = spread(t.bound / t.smallest for t in found)
    at_limit = sum(study.large_k.below is None for study in studies)
    return [
        tally(
            "The resulting path remains the shortest path for node i when K is sufficiently large (our bound).",
            (study.large_k.at_bound for study in studies),
            f"from K = {spread(t.smallest for t in found)} on; proved from W* + Q* / (2 gap) = "
            f"{spread(t.bound for t in found)} on, {ratio} times that; gap to the second-shortest path "
            f"{spread(t.gap for t in found)}",
        ),
        tally(
            f"(ours) GABF's path is the shortest {PRECISION:.1%} above the smallest K, and not {PRECISION:.1%} below.",
            (study.large_k.above and not study.large_k.below for study in studies),
            f"on {at_limit} graphs only the longest arc keeps K from being smaller; on "
            f"{sum(t.holds_below for t in found)} the path is right at some smaller K as well",
        ),
        tally(
            f"(ours) One K serves every graph: K = {SIDE:g}, the side of the square.",
            (t.smallest <= SIDE for t in found),
            f"K = 1 / beta = {1.0 / beta:g} serves {sum(t.smallest <= 1.0 / beta for t in found)}; the smallest K "
            "grows as the gap to the second-shortest path closes, so no K serves all graphs there are",
        ),
    ]


def _properties(studies: Sequence[GraphStudy]) -> list[Verdict]:
    zetas = [facts.zeta for study in studies for facts in study.stages]
    link = _link(FIRST_WEIGHT, None)
    ends = [float(link.arcs.progress(0.0, 1.0 - 10.0**-k)[0]) for k in (1, 4, 8)]
    return [
        tally(
            "f_i maps R_[0,1) x R_>0 into R_(0,1).",
            [_refusal() is None],
            f"with w = 2K, f(a) = 2 - a > 1, falling in a: it takes w < K, and the planner refuses: {_refusal()}",
        ),
        tally(
            "f_i satisfies the progressive property (one zeta > 0 for every a in [0, 1)).",
            [float(link.arcs.progress(0.0, 1.0)[0]) > 0.0],
            "f(a) - a = (1 - a)(1 - wbar) vanishes as a reaches 1: with wbar = 0.5 zeta up to a = 1 - 1e-1, 1 - 1e-4, "
            f"1 - 1e-8 is {', '.join(f'{zeta:.1g}' for zeta in ends)}",
        ),
        tally(
            "(ours) f_i is progressive and increasing on what each run sees, all weights being in (0, 1).",
            (study.always(lambda f: f.wbar_min > 0.0 and f.wbar_max < 1.0 and f.zeta > 0.0) for study in studies),
            f"zeta {spread(zetas)} over {len(zetas)} planning stages",
        ),
    ]


def _field(studies: Sequence[GraphStudy]) -> list[Verdict]:
    stages = [facts for study in studies for facts in study.stages]
    warm, cold = ([getattr(f, name) for s in studies for f in s.trained] for name in ("warm_tau", "cold_tau"))
    return [
        tally(
            "x_i(t) can be directly incorporated into the learning process (1 - x_i is the product of the weights).",
            (study.always(lambda facts: facts.path_error <= ROUNDING) for study in studies),
            f"largest relative difference {max(facts.path_error for facts in stages):.2g}",
        ),
        tally(
            "(ours) Eq. (wb) is additive under -ln(1 - x): SciPy's Dijkstra on -ln wbar finds the same field.",
            (study.always(lambda facts: facts.product_error <= ROUNDING) for study in studies),
            f"largest difference over all nodes {max(facts.product_error for facts in stages):.2g}; GABF against its "
            f"own oracle {max(facts.oracle_error for facts in stages):.2g}",
        ),
        tally(
            "The resulting wbar_ij can facilitate the computation (from the last x it settles sooner than from 0).",
            (sum(f.warm_tau for f in s.trained) < sum(f.cold_tau for f in s.trained) for s in studies),
            f"settling tau of a stage {spread(warm)} from the last x, {spread(cold)} from 0",
        ),
    ]


def _law(studies: Sequence[GraphStudy]) -> list[Verdict]:
    soon = [settled for study in studies for T, _, settled in study.law.runs if T == SOON]
    times = [facts.settling_time for study in studies for facts in study.stages]
    worst = studies[0].graph.network.n_nodes - 1
    return [
        tally(
            "The law ensures convergence within a user-defined time, in a knowledge-free sense.",
            (study.law.in_time and study.always(lambda facts: facts.settling_time < T_P) for study in studies),
            f"one set of parameters and x(0) = 0 for all graphs: settled at t = {spread(times)} s of T_p = {T_P:g} s; "
            f"with T_p = {SOON:g} s at {spread(soon)} s, from below and from above x*",
        ),
        tally(
            "The modified Bellman-Ford algorithm requires prior knowledge of the graph (to know when it may stop).",
            (study.law.sweeps < worst for study in studies),
            f"{spread((s.law.sweeps for s in studies), '.0f')} sweeps from above settle x; to be sure of that without "
            f"knowing the graph takes {worst}, and so the number of nodes",
        ),
        tally(
            "(ours) The learning is not free of knowledge: beta = 1 / K must be below the graph's own, as it is here.",
            (study.threshold.smallest <= 1.0 / ERROR_DRIVEN.beta for study in studies),
            f"beta = {ERROR_DRIVEN.beta:g}; and every arc is told its own d_ij",
        ),
    ]


def _link(weight: float, K: float | None) -> gabf.Network:
    """One node that reads one source."""
    indptr, indices = np.array([0, 0, 1]), np.array([0])
    return gabf.Network(indptr, indices, np.array([weight]), np.array([0]), kernel=gabf.Multiplicative(K))


def _refusal() -> str | None:
    """What the kernel says of a weight of 2K, if anything."""
    try:
        _link(2.0, 1.0)
    except AssumptionError as error:
        return str(error)
    return None


def _rule(studies: Sequence[GraphStudy]) -> list[Verdict]:
    out = [study.rule.first_outside for study in studies if study.rule.first_outside]
    fast = [study.rule.fast_outside for study in studies if study.rule.fast_outside]
    return [
        tally(
            "Smaller distances lead to larger reward values and larger weight updates (at equal activity).",
            (study.rule.equal_activity for study in studies),
            "R = 1 - beta d falls in d for any beta > 0",
        ),
        tally(
            "... larger weight updates (as the rule acts, at the activities that the arcs have).",
            (study.rule.concordant == 1.0 for study in studies),
            f"of two arcs the shorter one has the larger update in {spread(s.rule.concordant for s in studies)} of all "
            "pairs: the activity, at first 0.5 to the power of the hops, decides, and not the distance",
        ),
        tally(
            f"(ours) The rule as printed keeps every wbar_ij in (0, 1) for {studies[0].rule.tried} iterations "
            f"({HEBBIAN.label}).",
            (study.rule.first_outside == 0 for study in studies),
            f"a weight leaves (0, 1) on {len(out)}, first after iteration {spread(out)}, and with alpha = "
            f"{ERROR_DRIVEN.alpha:g} on {len(fast)}, after iteration {spread(fast)}; weights only grow while "
            f"beta d < 1, and are held at {HEBBIAN.ceiling:g} here",
        ),
    ]


def _at_once(studies: Sequence[GraphStudy]) -> list[Verdict]:
    both = [study.in_turn for study in studies if study.in_turn is not None]
    if not both:
        return []
    names = {"at_once": "at once", "by_node": "in turn from the start", "outwards": "in turn from the goal"}
    found = {title: _means([getattr(pair, name) for pair in both])[1:] for name, title in names.items()}
    return [
        tally(
            "GABF enables simultaneous training of each wbar_ij, in contrast to sequential training.",
            (pair.at_once[-1] >= max(pair.by_node[-1], pair.outwards[-1]) for pair in both),
            f"{ERROR_DRIVEN.label}: share of shortest paths by iteration "
            + "; ".join(f"{title} {_list(values)}" for title, values in found.items())
            + f"; planning stages an iteration 1 at once, {spread(pair.solves for pair in both)} in turn",
        )
    ]


def _simulation(studies: Sequence[GraphStudy], rule: LearningRule) -> list[Verdict]:
    """What the text says of fig. (learning), for one rule; iterations that were not run are not judged."""
    stages = list(zip(*(study.facts(rule) for study in studies), strict=True))
    name, first, end = f"({rule.label})", stages[1], stages[-1]
    last = len(stages) - 1
    off = spread(facts.off_target / rule.beta for facts in end)
    found = [
        tally(
            f"The trained weights wbar_ij approximate 1 - w_ij / K {name}.",
            (facts.off_target <= CLOSE * rule.beta for facts in end),
            f"after the last iteration the median |wbar - (1 - beta d)| is {off} beta; correlation of weights with "
            f"distances {spread((facts.correlation for facts in end), '.2f')}",
        ),
        tally(
            f"After the initial training, GABF produces a feasible but suboptimal path {name}.",
            (not facts.optimal for facts in first),
            f"every path is feasible, those counted are suboptimal; {_excess(first)}",
        ),
    ]
    for k, who in ((2, "as the text says"), (3, "as the figure says")):
        if k <= last:
            found.append(_improved(f"After {k} training iterations ({who})", name, first, stages[k]))
    sixth = "the sixth" if last == 6 else f"the last ({last})"
    by_iteration = shares(studies, rule)
    found.append(
        tally(
            f"After {sixth} training iteration, GABF identifies and converges to the shortest path {name}.",
            (facts.optimal for facts in end),
            f"{_excess(end)}; share of shortest paths by iteration {_list(by_iteration[1:])}, before any "
            f"{by_iteration[0]:.3g}",
        )
    )
    return found


def _improved(when: str, name: str, before: Sequence[StageFacts], after: Sequence[StageFacts]) -> Verdict:
    pairs = list(zip(before, after, strict=True))
    return tally(
        f"{when} the path is improved but still non-optimal {name}.",
        (b.excess < a.excess and not b.optimal for a, b in pairs),
        f"optimal on {sum(b.optimal for b in after)}; as long as after iteration 1 on "
        f"{sum(b.excess == a.excess for a, b in pairs)}, longer on {sum(b.excess > a.excess for a, b in pairs)}; "
        f"{_excess(after)}",
    )


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.3g}" for value in values)


def _excess(facts: Sequence[StageFacts]) -> str:
    return f"longer than the shortest by {spread((100.0 * f.excess for f in facts), '.2g')} %"
