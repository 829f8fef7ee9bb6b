"""How one of many plans ended."""

from __future__ import annotations

from planner.batch.outcomes import NO_PATH, SOLVED
from planner.problem.outcome import Outcome


def test_the_words_are_those_of_a_plan() -> None:
    assert {SOLVED, NO_PATH} <= {outcome.key for outcome in Outcome}
