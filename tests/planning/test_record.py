"""``plan.json`` is as its schema says, and the rows of its table promise no more than the record holds."""

from functools import cache
from typing import Any

import jsonschema
import numpy as np
import pydantic
import pytest
import yaml

import planner
from planner.base.resources import robot_names, robots_folder, scenes_folder, versions
from planner.cost.scale import manipulability_cost
from planner.kinematics.manipulability import manipulability
from planner.planning.base_result import RunRecord
from planner.planning.plan import plan
from planner.planning.record import PlanRecord
from planner.planning.result import Plan
from planner.problem.outcome import FORMAT_VERSION
from planner.problem.request import PlanRequest, TimingRequest
from planner.trajectory.measure import dense_path
from tests.planning.records import SMALL, as_written, spoilt, unknown_keys

UNREACHED: dict[str, Any] = {"robot": "planar_2r", "scene": "empty", "nodes": 2, "min_manipulability": 0.199}


@cache
def small() -> tuple[Plan, ...]:
    """With a motion, without, and without a path."""
    timed = plan(request=PlanRequest.from_options(**SMALL), timing=TimingRequest())
    return (
        timed,
        plan(request=PlanRequest.from_options(**SMALL), timing=None),
        plan(request=PlanRequest.from_options(**UNREACHED), timing=None),
    )


@pytest.mark.parametrize("validator", ["plan"], indirect=True)
def test_plans_are_as_the_schema_says(validator: jsonschema.Draft202012Validator, solved: Plan) -> None:
    """The types of the record are the schema: nothing is written that it does not know, at any depth."""
    schema = pydantic.TypeAdapter(PlanRecord).json_schema()
    for made in (solved, *small()):
        record = as_written(made.to_dict())
        validator.validate(record)
        assert unknown_keys(record, schema) == []
        assert not any(validator.is_valid(bad) for bad in spoilt(record))


def test_a_written_plan_is_read_as_the_same_record_with_whatever_comes_later(solved: Plan) -> None:
    made, written = solved, {}
    for made in (solved, *small()):
        written = as_written(made.to_dict())
        read = pydantic.TypeAdapter(PlanRecord).validate_python(written | {"from_the_future": 1})
        assert as_written(read.to_dict()) == written
        assert read.rows == made.record.rows
    assert made.record.format_version == FORMAT_VERSION
    assert made.record.versions == versions()
    for key, value in (("seed", "zero"), ("config", None), ("joints", "a")):
        with pytest.raises(pydantic.ValidationError, match=key):
            pydantic.TypeAdapter(RunRecord).validate_python(written | {key: value})


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


# the table


def test_a_dip_of_w_between_the_states_of_edges_is_told() -> None:
    """Refinement seeks what is priced too low: with 1/w a path cost a quarter more than was said."""
    plan = planner.plan(
        robot="kinova", scene="empty", start="home", goal="xyz:0.3,0.3,0.5", beta=0.0, manipulability_cost="inverse",
        nodes=150, timing=None,
    )  # fmt: skip
    record, scale = plan.to_dict(), plan.roadmap.scale
    states = dense_path(plan.path, 1e-3)
    omega = manipulability_cost(manipulability(plan.robot, states), scale, "inverse")
    step = np.linalg.norm(np.diff(states, axis=0), axis=1) / scale.joint_length
    finely = float((0.5 * (omega[1:] + omega[:-1]) * step).sum())
    assert record["quality"]["manipulability_cost"] == pytest.approx(finely, rel=2e-3)
    assert finely > 1.1 * record["cost"]["manipulability"]
