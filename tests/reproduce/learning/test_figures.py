"""The figures of Section 4.3."""

from __future__ import annotations

from dataclasses import replace

from planner.reproduce.learning.figures import most_telling
from planner.reproduce.learning.study import ERROR_DRIVEN, GraphStudy


def test_the_graph_that_is_drawn_is_most_like_the_papers_figure(study: GraphStudy) -> None:
    run = study.runs[ERROR_DRIVEN.name]

    def off(*excess: float) -> GraphStudy:
        facts = tuple(replace(f, excess=e) for f, e in zip(run.facts, excess, strict=False))
        return replace(study, runs={ERROR_DRIVEN.name: replace(run, facts=facts)})

    at_once, stuck, improved = off(0.3, 0.5, 0.1, 0.0), off(0.3, 0.4, 0.4, 0.4), off(0.3, 0.2, 0.2, 0.1)
    assert most_telling([at_once, stuck, improved]) is improved
    assert most_telling([off(0.3, 0.1, 0.1, 0.05), improved]) is improved
    assert most_telling([stuck, at_once]) is at_once
    one_iteration = off(0.3, 0.2)
    assert most_telling([one_iteration]) is one_iteration
