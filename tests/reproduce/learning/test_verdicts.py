"""Verdicts on Section 4.3."""

from __future__ import annotations

from dataclasses import replace

from planner.reproduce.learning.run import study_graph
from planner.reproduce.learning.study import ERROR_DRIVEN, GraphStudy
from planner.reproduce.learning.verdicts import learning_verdicts


def test_doctored_stages_are_not_confirmed(study: GraphStudy) -> None:
    run = study.runs[ERROR_DRIVEN.name]
    facts = list(run.facts)
    facts[-1] = replace(facts[-1], optimal=False, off_target=0.1, product_error=1.0, path_error=1.0, settling_time=9.0)
    wrong = replace(study, runs={**study.runs, ERROR_DRIVEN.name: replace(run, facts=tuple(facts))})
    before, after = (learning_verdicts([graph]) for graph in (study, wrong))
    changed = {a.sentence.split(" (")[0] for a, b in zip(before, after, strict=True) if a.holds and not b.holds}
    assert {sentence[:32] for sentence in changed} == {
        "x_i(t) can be directly incorpora",
        "(ours) Eq.",
        "The law ensures convergence with",
        "The trained weights wbar_ij appr",
        "After the sixth training iterati",
    }


def test_fewer_iterations_are_not_judged_on_later_ones() -> None:
    verdicts = learning_verdicts([study_graph(20, iterations=1, seed=0)])
    assert not any("2 training iterations" in verdict.sentence for verdict in verdicts)
    assert any("the last (1) training iteration" in verdict.sentence for verdict in verdicts)
    assert learning_verdicts([]) == ()
