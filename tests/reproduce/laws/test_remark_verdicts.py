"""Verdicts on the paper's remarks."""

from __future__ import annotations

from dataclasses import replace

from planner.reproduce.laws.near_deadline import ABOVE, BELOW, FIRST, TRIALS, Trial, remark_verdicts
from tests.reproduce.laws.test_verdicts import ideal_runs


def trials(**changes) -> list[Trial]:
    """Trials as remark (implementation) has them; ``changes`` by the first word of the method."""
    found = []
    for case, name, _ in TRIALS:
        last = 900.0 if name.startswith("forward") and case == ABOVE else 1e-5
        trial = Trial(0, case, name, 1e-6, last, 1e-5, not name.endswith("up to T_p"), 1000)
        found.append(replace(trial, **changes.get(name.split()[0].strip(",").lower(), {})))
    return found


def test_the_remark_is_confirmed_and_can_be_refuted() -> None:
    runs = [run for run in ideal_runs() if run.graph == 0]
    explicit, implicit, practical, above, below = remark_verdicts(trials(), runs)
    assert all(verdict.holds for verdict in (explicit, implicit, practical, above, below))
    explicit = remark_verdicts(trials(forward={"last": 1e-5}), runs)[0]
    implicit = remark_verdicts(trials(backward={"last": 2.0}), runs)[1]
    practical = remark_verdicts(trials(rk45={"practical": 0.5}), runs)[2]
    late = [replace(run, settling_time=3.99) if run.case.start == "below" else run for run in runs]
    assert [v.confirmed for v in (explicit, implicit, practical, *remark_verdicts(trials(), late)[3:])] == [
        0,
        0,
        0,
        1,
        0,
    ]
    assert {case for case, _, _ in TRIALS} == {ABOVE, BELOW, FIRST}
