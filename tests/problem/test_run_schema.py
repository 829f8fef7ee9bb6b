"""What every written record has in common, as a model: further keys are read, missing and spoilt ones are not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pydantic
import pytest

from planner.cost.scale import CostScale
from planner.planning.run_record import RunRecord, run_record
from planner.problem.outcome import Outcome
from planner.problem.request import RoadmapRequest
from planner.problem.run_schema import Record
from planner.robot.scene import Scene
from tests.worlds import load

RECORD = pydantic.TypeAdapter(RunRecord)


def record() -> dict[str, Any]:
    """As a run writes it."""
    return run_record(
        RoadmapRequest.from_options(robot="planar_2r"), Outcome.SOLVED, load("planar_2r"), Scene.load("empty")
    )


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


@dataclass(frozen=True, kw_only=True)
class Inner(Record):
    at: tuple[float, ...]
    more: int | None = None


@dataclass(frozen=True, kw_only=True)
class Outer(Record):
    inner: Inner | None
    scale: CostScale


def test_a_record_is_what_is_written_key_by_key() -> None:
    """Records and other dataclasses in it as plain data; null is written, a default is not."""
    scale = CostScale(0.1, 0.2, 3.0, 1.0, 0.01)
    assert Outer(inner=Inner(at=(1.0, 2.0)), scale=scale).to_dict() == {
        "inner": {"at": [1.0, 2.0]},
        "scale": vars(scale),
    }
    assert Outer(inner=None, scale=scale).to_dict()["inner"] is None
    assert Inner(at=(), more=3).to_dict() == {"at": [], "more": 3}
