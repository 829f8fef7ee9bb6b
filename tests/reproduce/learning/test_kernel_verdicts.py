"""What is said of eq. (wb): confirmed on a real graph, and not where the numbers say otherwise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from planner.reproduce.learning.study import T_P, GraphStudy
from planner.reproduce.learning.verdicts import kernel_verdicts
from planner.reproduce.report import Verdict


def by_begin(study: GraphStudy, begin: str) -> Verdict:
    (found,) = (verdict for verdict in kernel_verdicts([study]) if verdict.sentence.startswith(begin))
    return found


def spoilt(study: GraphStudy, **changes) -> GraphStudy:
    """The study with one stage of one rule changed."""
    name, run = next(iter(study.runs.items()))
    return replace(
        study, runs=study.runs | {name: replace(run, facts=(replace(run.facts[0], **changes), *run.facts[1:]))}
    )


DOCTORED: dict[str, Callable[[GraphStudy], GraphStudy]] = {
    "The resulting path remains": lambda s: replace(s, large_k=replace(s.large_k, at_bound=False)),
    "(ours) GABF's path is the shortest": lambda s: replace(s, large_k=replace(s.large_k, below=True)),
    "(ours) f_i is progressive": lambda s: spoilt(s, zeta=0.0),
    "x_i(t) can be directly": lambda s: spoilt(s, path_error=1e-3),
    "(ours) Eq. (wb) is additive": lambda s: spoilt(s, product_error=1e-3),
    "The law ensures convergence": lambda s: spoilt(s, settling_time=T_P),
    "The modified Bellman-Ford": lambda s: replace(s, law=replace(s.law, sweeps=10_000)),
}


@pytest.mark.parametrize("begin", DOCTORED)
def test_a_doctored_graph_is_not_confirmed(study: GraphStudy, begin: str) -> None:
    assert by_begin(study, begin).holds
    assert not by_begin(DOCTORED[begin](study), begin).holds


def test_what_the_kernel_refuses_is_quoted(study: GraphStudy) -> None:
    verdict = by_begin(study, "f_i maps")
    assert not verdict.holds
    assert "the planner refuses: " in verdict.note
    assert "None" not in verdict.note
