"""A task's ``plan.json`` is as ``planner schema plan`` says."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pydantic
import pytest

import planner
from planner.base.errors import FileError
from planner.robot.scene import write_scene
from planner.tasks.plan import task
from planner.tasks.result import TaskPlan, TaskPlanRecord, _scene_in_motion
from tests.planning.records import as_written, spoilt, unknown_keys
from tests.tasks.cases import SCENE, SMALL, small


@pytest.mark.parametrize("validator", ["plan"], indirect=True)
def test_tasks_are_as_the_schema_says_and_it_names_every_key(validator: jsonschema.Draft202012Validator) -> None:
    timed, plain = small().plan(), small().plan(timing=None)
    stuck = task(replace(SMALL, scene=replace(SCENE, constraints="plane:0,0,1,0.45")), nodes=20, timing=None)
    schema = pydantic.TypeAdapter(TaskPlanRecord).json_schema()
    for found in (timed, plain, stuck):
        record = as_written(found.to_dict())
        validator.validate(record)
        assert unknown_keys(record, schema) == []
    assert not any(validator.is_valid(record) for record in spoilt(as_written(timed.to_dict())))


def test_a_planned_task_is_loaded_as_it_was_saved(tmp_path: Path) -> None:
    """Checked, saved again and drawn as before, by its events alone."""
    scene = str(write_scene(SCENE, tmp_path / "desk.yaml")[0])
    made = task(replace(SMALL, scene=scene), nodes=100, ik_solutions=2)
    made.save(tmp_path / "out")
    found = planner.load(tmp_path / "out")
    assert isinstance(found, TaskPlan)
    assert (found.candidates, found.network, found.task.steps) == (None, None, ())
    assert as_written(found.to_dict()) == json.loads((tmp_path / "out" / "plan.json").read_text())
    np.testing.assert_array_equal(found.path, made.path)
    assert planner.check(found).to_dict() == planner.check(made).to_dict()
    found.save(tmp_path / "again")
    for name in ("roadmap.npz", "trajectory.json"):
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / "out" / name).read_bytes()
    assert found.trajectory is not None
    assert made.trajectory is not None
    (one,), (two,) = (
        _scene_in_motion(each, motion).moving for each, motion in ((found, found.trajectory), (made, made.trajectory))
    )
    np.testing.assert_array_equal(one.motion.poses, two.motion.poses)


def test_a_folder_is_loaded_by_what_it_holds(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"must be a folder with plan\.json or sweep\.json, got "):
        planner.load(tmp_path)
    planner.plan("planar_2r", "empty", start="q:0,1", goal="q:1,1", nodes=20).save(tmp_path)
    found = planner.load(tmp_path)
    assert isinstance(found, planner.Plan)
    assert planner.check(found).proven
    (tmp_path / "sweep.json").write_text("{}")
    with pytest.raises(FileError, match=r"got plan\.json"):
        planner.load(tmp_path)
    (tmp_path / "sweep.json").unlink()
    (tmp_path / "plan.json").write_text("[]")
    with pytest.raises(FileError, match="plan"):
        planner.load(tmp_path)
