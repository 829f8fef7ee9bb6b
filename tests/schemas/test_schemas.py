"""The schemas hold for what is written and read, and not for files that lack or spoil a key."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from planner.base.errors import FileError
from planner.base.formats import FORMAT_VERSION, require_readable_version
from planner.base.request import PlanRequest, SweepRequest
from planner.base.resources import robot_names, robots_folder, scene_names, scenes_folder
from planner.plan_record import Plan, plan_record
from planner.planning import plan
from planner.tradeoff.record import read_checkpoint, save_sweep, sweep_record
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
    for name in scene_names():
        validator.validate(yaml.safe_load((scenes_folder() / f"{name}.yaml").read_text()))
    assert not validator.is_valid({"obstacles": [{"name": "a", "type": "box"}]})
    assert not validator.is_valid({"obstacle": []})


@pytest.mark.parametrize("validator", ["robot"], indirect=True)
def test_robot_files_are_as_the_schema_says(validator: jsonschema.Draft202012Validator) -> None:
    for name in robot_names():
        validator.validate(yaml.safe_load((robots_folder() / name / "robot.yaml").read_text()))
    assert not validator.is_valid({"description": "no urdf"})


@pytest.mark.parametrize("version", [FORMAT_VERSION + 1, 0, "1", None, True, 10**60])
def test_other_versions_are_refused_with_the_remedy(version: object) -> None:
    with pytest.raises(FileError, match="update the planner"):
        require_readable_version({"format_version": version}, "it")


def test_a_plan_of_an_older_planner_is_read_and_of_a_newer_one_refused(solved: Plan, tmp_path: Path, run: Run) -> None:
    record, path = plan_record(solved), tmp_path / "plan.json"
    assert record.pop("format_version") == FORMAT_VERSION
    path.write_text(json.dumps(record))
    assert run("check", str(path), "--step", "0.1")[0] == 0
    path.write_text(json.dumps({**record, "format_version": FORMAT_VERSION + 1}))
    code, _, error = run("check", str(path))
    assert code == 3
    assert "update the planner" in error


def test_a_sweep_of_a_newer_planner_is_not_gone_on_from(tmp_path: Path) -> None:
    request = SweepRequest(**SMALL)
    record = save_sweep(sweep(request), tmp_path)
    read_checkpoint(request, tmp_path)
    (tmp_path / "sweep.json").write_text(json.dumps({**record, "format_version": FORMAT_VERSION + 1}))
    with pytest.raises(FileError, match="update the planner"):
        read_checkpoint(request, tmp_path)
