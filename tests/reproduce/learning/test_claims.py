"""Verdicts on Section 4.3: a real graph confirms them, a doctored one does not."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from reproduce.learning.run import learning_verdicts
from reproduce.learning.study import ERROR_DRIVEN, HEBBIAN, SOON, T_P, GraphStudy, InTurn, study_graph
from reproduce.verdict import Verdict


def by_begin(study: GraphStudy, begin: str) -> Verdict:
    (found,) = (verdict for verdict in learning_verdicts([study], 6) if verdict.sentence.startswith(begin))
    return found


def spoilt(study: GraphStudy, name: str = HEBBIAN.name, stage: int = 0, **changes) -> GraphStudy:
    """The study with one stage of one rule changed."""
    course = list(study.facts[name])
    course[stage] = replace(course[stage], **changes)
    return replace(study, facts=study.facts | {name: tuple(course)})


def in_turn(study: GraphStudy, best: bool) -> GraphStudy:
    return replace(study, in_turn=InTurn((False, best), (False, True), (False, False), 100))


LAST = f"({ERROR_DRIVEN.label})"
DOCTORED: dict[str, Callable[[GraphStudy], GraphStudy]] = {
    "The resulting path remains": lambda s: replace(s, shortest_at_large_K=False),
    "(ours) f_i is progressive": lambda s: spoilt(s, zeta=0.0),
    "x_i(t) can be directly": lambda s: spoilt(s, path_error=1e-3),
    "(ours) Eq. (wb) is additive": lambda s: spoilt(s, product_error=1e-3),
    "The resulting wbar_ij can facilitate": lambda s: spoilt(s, stage=1, warm_tau=1e3),
    "The law ensures convergence": lambda s: spoilt(s, settling_time=T_P),
    "The law ensures": lambda s: replace(s, soon=(0.01, SOON)),
    "The modified Bellman-Ford": lambda s: replace(s, sweeps=10_000),
    "Smaller distances lead": lambda s: replace(s, rule=replace(s.rule, equal_activity=False)),
    "(ours) The rule as printed": lambda s: replace(s, rule=replace(s.rule, first_outside=6)),
    f"The trained weights wbar_ij approximate 1 - w_ij / K {LAST}": lambda s: spoilt(
        s, ERROR_DRIVEN.name, -1, off_target=0.1
    ),
    f"After the sixth training iteration, GABF identifies and converges to the shortest path {LAST}": lambda s: spoilt(
        s, ERROR_DRIVEN.name, -1, optimal=False
    ),
}


@pytest.mark.parametrize("begin", DOCTORED)
def test_a_doctored_graph_is_not_confirmed(study: GraphStudy, begin: str) -> None:
    assert by_begin(study, begin).holds
    assert not by_begin(DOCTORED[begin](study), begin).holds


def test_simultaneous_training_is_judged_where_it_was_compared(study: GraphStudy) -> None:
    assert by_begin(study, "GABF enables").of == 0
    assert by_begin(in_turn(study, best=True), "GABF enables").holds
    assert not by_begin(in_turn(study, best=False), "GABF enables").holds


@pytest.mark.parametrize("begin", ["f_i maps", "f_i satisfies", "... larger weight updates"])
def test_what_cannot_hold_as_written_does_not(study: GraphStudy, begin: str) -> None:
    assert by_begin(study, begin).confirmed == 0 < by_begin(study, begin).of


def test_an_improved_path_is_shorter_and_not_the_shortest(study: GraphStudy) -> None:
    begin = f"After 2 training iterations (as the text says) the path is improved but still non-optimal {LAST}"
    first = spoilt(study, ERROR_DRIVEN.name, 1, excess=0.1, optimal=False)
    for excess, optimal, improved in ((0.05, False, True), (0.1, False, False), (0.0, True, False)):
        assert by_begin(spoilt(first, ERROR_DRIVEN.name, 2, excess=excess, optimal=optimal), begin).holds is improved


def test_fewer_iterations_are_not_judged_on_later_ones() -> None:
    verdicts = learning_verdicts([study_graph(20, iterations=1, seed=0)], 1)
    assert not any("2 training iterations" in verdict.sentence for verdict in verdicts)
    assert any("the last (1) training iteration" in verdict.sentence for verdict in verdicts)
