"""The section on learning-based path planning sentence by sentence: confirmed or not, on how many graphs, by what."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner.learning import LearningRule
from planner.reproduce.learning.cases import ERROR_DRIVEN, HEBBIAN, RULES, StageFacts
from planner.reproduce.learning.kernel_verdicts import kernel_verdicts
from planner.reproduce.learning.study import GraphStudy
from planner.reproduce.report import Verdict, spread, tally

CLOSE = 0.01
"""Trained weights "approximate" 1 - w / K if half of them are this close to it, in units of 1 / K."""


def learning_verdicts(studies: Sequence[GraphStudy]) -> tuple[Verdict, ...]:
    """Every sentence of the section; counts are of graphs unless there is but one case."""
    if not studies:
        return ()
    found = [*kernel_verdicts(studies), *_rule(studies), *_at_once(studies)]
    for rule in RULES:
        found += _simulation(studies, rule)
    return (*found, _connected(studies))


def shares(runs: Sequence[Sequence[bool]]) -> list[float]:
    """The share of True at each place, over the runs."""
    return np.array(runs, dtype=float).mean(axis=0).tolist() if runs else []


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
    found = {title: shares([getattr(pair, name) for pair in both])[1:] for name, title in names.items()}
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
    found = [
        _approximates(rule, name, end),
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
    by_iteration = shares([[facts.optimal for facts in study.facts(rule)] for study in studies])
    found.append(
        tally(
            f"After {sixth} training iteration, GABF identifies and converges to the shortest path {name}.",
            (facts.optimal for facts in end),
            f"{_excess(end)}; share of shortest paths by iteration {_list(by_iteration[1:])}, before any "
            f"{by_iteration[0]:.3g}",
        )
    )
    return found


def _approximates(rule: LearningRule, name: str, end: Sequence[StageFacts]) -> Verdict:
    off = spread(facts.off_target / rule.beta for facts in end)
    return tally(
        f"The trained weights wbar_ij approximate 1 - w_ij / K {name}.",
        (facts.off_target <= CLOSE * rule.beta for facts in end),
        f"after the last iteration the median |wbar - (1 - beta d)| is {off} beta; correlation of weights with "
        f"distances {spread((facts.correlation for facts in end), '.2f')}",
    )


def _improved(when: str, name: str, before: Sequence[StageFacts], after: Sequence[StageFacts]) -> Verdict:
    pairs = list(zip(before, after, strict=True))
    return tally(
        f"{when} the path is improved but still non-optimal {name}.",
        (b.excess < a.excess and not b.optimal for a, b in pairs),
        f"optimal on {sum(b.optimal for b in after)}; as long as after iteration 1 on "
        f"{sum(b.excess == a.excess for a, b in pairs)}, longer on {sum(b.excess > a.excess for a, b in pairs)}; "
        f"{_excess(after)}",
    )


def _connected(studies: Sequence[GraphStudy]) -> Verdict:
    redraws = sum(study.graph.redraws for study in studies)
    outside = [study.graph.outside for study in studies]
    return tally(
        "(ours) A graph as described has a path from every node (counts are of drawn graphs).",
        [True] * len(studies) + [False] * redraws,
        f"the others were thrown away; {spread((s.graph.d.size / 2 for s in studies), '.0f')} links; the offset moves "
        f"{spread(outside, '.0f')} of the 36 nodes out of [0,1] x [0,1]",
    )


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.3g}" for value in values)


def _excess(facts: Sequence[StageFacts]) -> str:
    return f"longer than the shortest by {spread((100.0 * f.excess for f in facts), '.2g')} %"
