"""What every written record has in common, as a model: further keys are read, missing and spoilt ones are not."""

from __future__ import annotations

from typing import Any

import pydantic
import pytest

from planner.models.run_record import run_record
from planner.models.scene import Scene
from planner.problem.outcome import Outcome
from planner.problem.request import RoadmapRequest
from planner.problem.run_schema import RunRecord
from tests.worlds import load

RECORD = pydantic.TypeAdapter(RunRecord)


def record() -> dict[str, Any]:
    """As a run writes it."""
    return run_record(RoadmapRequest("planar_2r"), Outcome.SOLVED, load("planar_2r"), Scene.load("empty"))


def test_what_a_run_writes_is_read_with_whatever_comes_later() -> None:
    assert RECORD.validate_python(record() | {"from_the_future": 1}).to_dict() == record()


@pytest.mark.parametrize(("key", "value"), [("seed", "zero"), ("config", None), ("joints", "a")])
def test_what_is_missing_or_spoilt_is_not(key: str, value: object) -> None:
    whole = record()
    with pytest.raises(pydantic.ValidationError, match=key):
        RECORD.validate_python(whole | {key: value})
    del whole[key]
    with pytest.raises(pydantic.ValidationError, match=key):
        RECORD.validate_python(whole)
