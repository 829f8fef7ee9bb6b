"""``plan.json`` is as its schema says."""

from __future__ import annotations

from typing import Any

import jsonschema
import pytest

from planner.planning.plan import plan
from planner.planning.result import Plan, plan_record
from planner.problem.request import PlanRequest
from tests.planning.records import SMALL, as_written, spoilt

UNREACHED: dict[str, Any] = {"robot": "planar_2r", "scene": "empty", "nodes": 2, "min_manipulability": 0.199}


@pytest.mark.parametrize("validator", ["plan"], indirect=True)
def test_plans_are_as_the_schema_says(validator: jsonschema.Draft202012Validator, solved: Plan) -> None:
    records = [
        as_written(plan_record(made)) for made in (solved, plan(PlanRequest(**SMALL)), plan(PlanRequest(**UNREACHED)))
    ]
    for record in records:
        validator.validate(record)
    assert not any(validator.is_valid(record) for record in spoilt(records[0]))
