"""Records are written key by key."""

from dataclasses import dataclass

import pydantic

from planner.cost.scale import CostScale
from planner.problem.outcome import Record


@dataclass(frozen=True, kw_only=True)
class Inner(Record):
    at: tuple[float, ...]
    """m"""
    more: int | None = None


@dataclass(frozen=True, kw_only=True)
class Outer(Record):
    inner: Inner | None
    scale: CostScale


def test_a_record_is_written_key_by_key() -> None:
    """Records and other dataclasses in it as plain data; null is written, a default is not."""
    scale = CostScale(0.1, 0.2, 3.0, 1.0, 0.01)
    whole = {"inner": {"at": [1.0, 2.0]}, "scale": vars(scale)}
    assert Outer(inner=Inner(at=(1.0, 2.0)), scale=scale).to_dict() == whole
    assert Outer(inner=None, scale=scale).to_dict()["inner"] is None
    assert Inner(at=(), more=3).to_dict() == {"at": [], "more": 3}
    read = pydantic.TypeAdapter(Outer)
    assert read.validate_python(whole | {"from_the_future": 1}).to_dict() == whole
    assert read.json_schema()["$defs"]["Inner"]["properties"]["at"]["description"] == "m"
