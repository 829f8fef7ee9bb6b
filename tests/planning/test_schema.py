"""``plan.json`` is as its schema says."""

from __future__ import annotations

from typing import Any

import jsonschema
import pydantic
import pytest

from planner.planning.plan import plan
from planner.planning.record import PlanRecord
from planner.planning.result import Plan, plan_record
from planner.problem.request import PlanRequest, TimingRequest
from tests.planning.records import SMALL, as_written, spoilt, unknown_keys

UNREACHED: dict[str, Any] = {"robot": "planar_2r", "scene": "empty", "nodes": 2, "min_manipulability": 0.199}


@pytest.mark.parametrize("validator", ["plan"], indirect=True)
def test_plans_are_as_the_schema_says(validator: jsonschema.Draft202012Validator, solved: Plan) -> None:
    records = [
        as_written(plan_record(made))
        for made in (solved, plan(PlanRequest.from_options(**SMALL)), plan(PlanRequest.from_options(**UNREACHED)))
    ]
    for record in records:
        validator.validate(record)
    assert not any(validator.is_valid(record) for record in spoilt(records[0]))


def test_the_schema_names_every_key_that_is_written(solved: Plan) -> None:
    """The record's own types are the schema: nothing is written that it does not know, at any depth."""
    schema = pydantic.TypeAdapter(PlanRecord).json_schema()

    timed = plan(PlanRequest.from_options(**SMALL), timing=TimingRequest())
    for made in (solved, timed, plan(PlanRequest.from_options(**UNREACHED))):
        assert unknown_keys(as_written(plan_record(made)), schema) == []
