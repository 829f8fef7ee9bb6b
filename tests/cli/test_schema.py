"""``planner schema``: sound schemas of four files, and of nothing else. What they hold for: tests/planning."""

from __future__ import annotations

import json
from typing import get_args

import jsonschema
import pytest

from planner.cli.catalogue import Format
from tests.command_line import Run


@pytest.mark.parametrize("name", get_args(Format))
def test_it_prints_a_schema_and_nothing_else(name: str, run: Run) -> None:
    code, out, err = run("schema", name)
    assert (code, err) == (0, "")
    schema = json.loads(out)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema.get("properties") or schema["anyOf"]
