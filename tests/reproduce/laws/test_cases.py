"""The laws that are compared."""

from __future__ import annotations

from planner.reproduce.laws.cases import CASES, FREE, PRESCRIBED


def test_the_cases_are_those_of_the_paper() -> None:
    assert len(PRESCRIBED) == 4
    assert len(FREE) == 2 * 16
    assert {case.law.T for case in CASES} == {4.0}
    assert [case.label for case in PRESCRIBED] == ["h = 1", "h = 2", "h = 4", "h = 8"]
    assert FREE[0].label == "p1/p2 = 3/5, m1/m2 = 9/7"
