"""A task's ``plan.json`` is as ``planner schema plan`` says."""

from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pydantic
import pytest

from planner.problem.request import TimingRequest
from planner.tasks.plan import task
from planner.tasks.result import TaskPlanRecord
from tests.planning.records import as_written, spoilt, unknown_keys
from tests.tasks.cases import SCENE, SMALL, small
from tests.worlds import load


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


def test_a_start_in_another_turn_is_noted(tmp_path: Path) -> None:
    home = load("kinova").home
    turned = ",".join(map(repr, (home + 2 * np.pi * np.eye(6)[0]).tolist()))
    (tmp_path / "task.yaml").write_text(f"robot: kinova\nscene: empty\nstart: 'q:{turned}'\nsteps:\n- move: home\n")
    found = task(tmp_path / "task.yaml", nodes=10, ik_solutions=1)
    (note,) = (text for text in found.to_dict()["notes"] if "in another turn" in text)
    assert f"the plan begins at {home[0]:.6g}," in note
