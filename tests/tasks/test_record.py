"""A task's ``plan.json`` is as ``planner schema plan`` says."""

from __future__ import annotations

from dataclasses import replace

import jsonschema
import pydantic
import pytest

from planner.problem.request import TimingRequest
from planner.tasks.plan import task
from planner.tasks.record import TaskPlanRecord
from tests.planning.records import as_written, spoilt, unknown_keys
from tests.tasks.cases import SCENE, SMALL, small


@pytest.mark.parametrize("validator", ["plan"], indirect=True)
def test_tasks_are_as_the_schema_says_and_it_names_every_key(validator: jsonschema.Draft202012Validator) -> None:
    timed, plain = small().plan(timing=TimingRequest()), small().plan()
    stuck = task(replace(SMALL, scene=replace(SCENE, keep="plane:0,0,1,0.45")), nodes=20)
    schema = pydantic.TypeAdapter(TaskPlanRecord).json_schema()
    for found in (timed, plain, stuck):
        record = as_written(found.to_dict())
        validator.validate(record)
        assert unknown_keys(record, schema) == []
    assert not any(validator.is_valid(record) for record in spoilt(as_written(timed.to_dict())))
