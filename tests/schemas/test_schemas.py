"""The schemas hold for what is written and read, and not for files that lack or spoil a key."""

from __future__ import annotations

import copy
import json
from typing import Any

import jsonschema
import pytest
import yaml

from planner.base.request import PlanRequest, SweepRequest
from planner.base.resources import robot_names, robots_folder, scenes_folder
from planner.plan_record import Plan, plan_record
from planner.planning import plan
from planner.tradeoff.record import sweep_record
from planner.tradeoff.sweep import sweep
from tests.command_line import Run

SMALL: dict[str, Any] = {"robot": "planar_2r", "scene": "empty", "nodes": 60}
UNREACHED: dict[str, Any] = {"robot": "planar_2r", "scene": "empty", "nodes": 2, "min_manipulability": 0.199}


@pytest.fixture
def validator(request: pytest.FixtureRequest, run: Run) -> jsonschema.Draft202012Validator:
    """Of the schema that the command prints; made without the models."""
    code, out, _ = run("schema", request.param)
    assert code == 0
    schema = json.loads(out)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def as_written(record: dict[str, Any]) -> dict[str, Any]:
    return json.loads(json.dumps(record))


def spoilt(record: dict[str, Any]) -> list[dict[str, Any]]:
    """The record without its roadmap, with a text for the seed, and with a path of texts."""
    out = [copy.deepcopy(record) for _ in range(3)]
    del out[0]["roadmap"]
    out[1]["seed"] = "zero"
    out[2]["joints"] = [[1]]
    return out


@pytest.mark.parametrize("validator", ["plan"], indirect=True)
def test_plans_are_as_the_schema_says(validator: jsonschema.Draft202012Validator, solved: Plan) -> None:
    records = [
        as_written(plan_record(made)) for made in (solved, plan(PlanRequest(**SMALL)), plan(PlanRequest(**UNREACHED)))
    ]
    for record in records:
        validator.validate(record)
    assert not any(validator.is_valid(record) for record in spoilt(records[0]))


@pytest.mark.parametrize("validator", ["sweep"], indirect=True)
def test_sweeps_are_as_the_schema_says(validator: jsonschema.Draft202012Validator) -> None:
    records = [as_written(sweep_record(sweep(SweepRequest(**SMALL), front=front))) for front in (False, True)]
    for record in records:
        validator.validate(record)
    assert not any(validator.is_valid(record) for record in spoilt(records[0]))


@pytest.mark.parametrize("validator", ["scene"], indirect=True)
def test_scene_files_are_as_the_schema_says(validator: jsonschema.Draft202012Validator) -> None:
    for path in (*scenes_folder().glob("*.yaml"), *scenes_folder().glob("published/*.yaml")):
        validator.validate(yaml.safe_load(path.read_text()))
    assert not validator.is_valid({"obstacles": [{"name": "a", "type": "box"}]})
    assert not validator.is_valid({"obstacle": []})


@pytest.mark.parametrize("validator", ["robot"], indirect=True)
def test_robot_files_are_as_the_schema_says(validator: jsonschema.Draft202012Validator) -> None:
    for name in robot_names():
        validator.validate(yaml.safe_load((robots_folder() / name / "robot.yaml").read_text()))
    assert not validator.is_valid({"description": "no urdf"})
