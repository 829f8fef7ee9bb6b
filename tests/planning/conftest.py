"""A validator of the schema that the command prints."""

from __future__ import annotations

import json

import jsonschema
import pytest

from tests.command_line import Run


@pytest.fixture
def validator(request: pytest.FixtureRequest, run: Run) -> jsonschema.Draft202012Validator:
    """Of the schema that the command prints; made without the models."""
    code, out, _ = run("schema", request.param)
    assert code == 0
    schema = json.loads(out)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)
