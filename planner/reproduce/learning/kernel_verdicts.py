"""What the section says of eq. (wb) and of the law that settles it: confirmed or not, on how many graphs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner import gabf
from planner.base.errors import AssumptionError
from planner.learning import FIRST_WEIGHT
from planner.reproduce.learning.cases import ERROR_DRIVEN, SOON, T_P
from planner.reproduce.learning.study import GraphStudy
from planner.reproduce.learning.threshold import PRECISION
from planner.reproduce.report import Verdict, spread, tally

ROUNDING = 1e-9
"""What -ln(1 - x) and the additive cost may differ by: rounding of x near 1, where activities are as small as 1e-4."""

SIDE = 1.0
"""The side of the square, a K that one might think of."""


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
