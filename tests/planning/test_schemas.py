"""The schemas hold for what is written and read, and not for files that lack or spoil a key."""

from __future__ import annotations

import jsonschema
import pytest
import yaml

from planner.base.resources import robot_names, robots_folder, scenes_folder


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
