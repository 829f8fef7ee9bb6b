"""Verdicts on Section 4.1: ideal measurements confirm them, doctored ones do not."""

from dataclasses import replace

import numpy as np
import pytest

from reproduce.laws.cases import CASES, FREE, PRESCRIBED, LawCase, Measurement
from reproduce.laws.claims import CLAIMS, EFFORTS, FIRST, GraphStudy
from reproduce.report import judge
from reproduce.verdict import Verdict

GRAPHS = 3


def ideal(case: LawCase) -> Measurement:
    """A measurement on which every sentence of the paper is true."""
    if case in PRESCRIBED:
        h = PRESCRIBED.index(case)
        time, effort = 3.5 - 0.1 * h, 10.0 + h
    else:
        k = FREE.index(case) % 16
        time, effort = 1.0 + 0.1 * (k // 4) + 0.01 * (k % 4), 20.0 - (k // 4) - 0.1 * (k % 4)
    return Measurement(case, 10 * time, time, 0.1, effort, effort, 0.0, effort, effort, effort, 0.0, True)


def study(largest: float = 7.0) -> GraphStudy:
    return GraphStudy(500, 10.0, 12, largest, 11.0, 0, 0, tuple(map(ideal, CASES)))


def judged(odd: GraphStudy) -> dict[str, Verdict]:
    verdicts = judge(CLAIMS, [study(), odd, study()])
    assert len({verdict.sentence for verdict in verdicts}) == len(verdicts)
    return {verdict.sentence: verdict for verdict in verdicts}


def test_ideal_measurements_confirm_every_sentence() -> None:
    for verdict in judged(study()).values():
        assert verdict.holds, verdict
        assert verdict.of == GRAPHS


@pytest.mark.parametrize(
    ("case", "changes", "sentence"),
    [
        (PRESCRIBED[2], {"settling_time": 3.9}, "Larger h leads to faster"),
        (PRESCRIBED[2], {"node_input": 1.0}, "... as the control effort increases (prescribed"),
        (PRESCRIBED[0], {"settling_time": np.inf, "settling_tau": np.inf}, "All state errors converge"),
        (PRESCRIBED[0], {"within_bounds": False}, "All the control inputs remain bounded (prescribed"),
        (PRESCRIBED[0], {"largest_input": np.inf}, "All the control inputs remain bounded (prescribed"),
        (FREE[5], {"settling_tau": 1.0}, "Smaller p1/p2 yields faster convergence (singularity-free law, "),
        (FREE[5], {"settling_tau": 1.0}, "Smaller m1/m2 yields faster convergence (singularity-free law, "),
        (FREE[5], {"error": 1e-3}, "The state error converges before"),
        (FREE[5], {"last_input": 1.0}, "All the control inputs remain bounded (singularity-free"),
        (FREE[5], {"largest_input": 1e6}, "(ours) No input grows beyond"),
        (FREE[5], {"within_bounds": False}, "(ours) Every bound of the paper"),
        (FREE[5], {"settling_time": 3.7}, "Convergence typically occurs well before"),
    ],
)
def test_a_doctored_run_is_not_confirmed(case: LawCase, changes: dict, sentence: str) -> None:
    good = study()
    runs = tuple(replace(run, **changes) if run.case == case else run for run in good.runs)
    verdicts = judged(replace(good, runs=runs)).items()
    hit = [verdict for text, verdict in verdicts if text.startswith(sentence) and not verdict.holds]
    assert hit
    assert all(verdict.confirmed == GRAPHS - 1 for verdict in hit)


def test_a_start_below_is_no_overestimate() -> None:
    (verdict,) = (v for s, v in judged(study(10.5)).items() if "overestimated" in s)
    assert (verdict.confirmed, verdict.of) == (2, 3)


def test_each_reading_of_effort_is_judged_by_itself() -> None:
    good = study()
    odd = replace(good, runs=tuple(replace(run, energy=-run.energy) for run in good.runs))
    for sentence, verdict in judged(odd).items():
        if "control effort" in sentence:
            assert verdict.confirmed == GRAPHS - ("energy" in sentence)
    assert len(EFFORTS) == 4


def test_neighbours_differ_in_one_parameter() -> None:
    pairs = study().pairs(("singularity-free", "below"), "p1/p2")
    assert len(pairs) == 4 * 3
    for a, b in pairs:
        assert a.case.start == b.case.start == "below"
        assert a.case.parameters["m1/m2"] == b.case.parameters["m1/m2"]
        assert a.case.law.p[0] + 2 == b.case.law.p[0]
    assert len(study().pairs(FIRST, "h")) == 3


def test_the_cases_are_those_of_the_paper() -> None:
    assert (len(PRESCRIBED), len(FREE)) == (4, 2 * 16)
    assert {case.law.T for case in CASES} == {4.0}
    assert [case.label() for case in PRESCRIBED] == ["h = 1", "h = 2", "h = 4", "h = 8"]
    assert FREE[0].label() == "p1/p2 = 3/5, m1/m2 = 9/7"
    assert FREE[0].label(without="p1/p2") == "m1/m2 = 9/7"
