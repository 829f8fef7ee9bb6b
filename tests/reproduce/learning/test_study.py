"""All measurements on one graph."""

from __future__ import annotations

from planner.reproduce.learning.study import ERROR_DRIVEN, HEBBIAN, GraphStudy


def test_both_rules_start_from_the_same_field(study: GraphStudy) -> None:
    hebbian, error_driven = (study.runs[rule.name].stages[0].field.x for rule in (HEBBIAN, ERROR_DRIVEN))
    assert hebbian.tolist() == error_driven.tolist()
