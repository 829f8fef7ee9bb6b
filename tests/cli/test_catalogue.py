"""The lists of ``planner robots``, ``planner scenes`` and ``planner schema``."""

import json
from typing import get_args

import jsonschema
import pytest

from planner.cli.catalogue import Format
from planner.robot.scene import Scene
from tests.command_line import Run
from tests.worlds import load


@pytest.mark.parametrize("command", ["robots", "scenes"])
def test_every_name_that_one_may_type_is_listed(run: Run, command: str) -> None:
    code, out, _ = run(command)
    assert code == 0
    code, text, _ = run(command, "--json")
    assert code == 0
    for record in json.loads(text):
        typed = [record["name"]]
        if command == "robots":
            robot = load(record["name"])
            typed += [robot.tool, *robot.joints]
            assert [joint["name"] for joint in record["joints"]] == list(robot.joints)
            assert record["home"] == robot.home.tolist()
        else:
            scene = Scene.load(record["name"])
            typed += [name for states in scene.states.values() for name in states]
            assert record["obstacles"] == [obstacle.name for obstacle in scene.obstacles]
        assert set(typed) <= set(out.replace(",", " ").replace(":", " ").split())


@pytest.mark.parametrize("name", get_args(Format))
def test_a_schema_is_sound_and_nothing_else_is_printed(name: str, run: Run) -> None:
    code, out, err = run("schema", name)
    assert (code, err) == (0, "")
    schema = json.loads(out)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema.get("properties") or schema["anyOf"]
