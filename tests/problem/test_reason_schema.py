"""``reason`` in ``plan.json``: every reason for no path as the schema says, and none that lacks or spoils a key."""

from __future__ import annotations

import json
from typing import Any

import pydantic
import pytest

from planner.problem.reason_schema import ReasonRecord
from planner.problem.reasons import (
    BlockedInTime,
    BudgetSpent,
    CannotFollow,
    FloorTooHigh,
    Gap,
    KeptTooNarrow,
    NoPath,
    Separated,
)

RECORD: pydantic.TypeAdapter[Any] = pydantic.TypeAdapter(ReasonRecord)
NEAR = Gap(0.1, (0.0, 1.0), (0.1, 1.0), ("hand", "shelf"))
UNSTOPPED = Gap(2.0, (0.0,), (2.0,), None)
REASONS: list[NoPath] = [
    Separated(("wall",), NEAR),
    BudgetSpent(300, UNSTOPPED),
    FloorTooHigh(0.3, 0.2),
    KeptTooNarrow(("axis:z,0,0,1,0.1",), Gap(0.5, (0.0,), (0.5,), None)),
    BlockedInTime("goal", ("cart",)),
    CannotFollow(3, 0.25, "touching", between=("hand", "shelf")),
]


def written(reason: NoPath) -> dict[str, Any]:
    return json.loads(json.dumps(reason.to_dict()))


def test_every_reason_for_no_path_has_its_record() -> None:
    for reason in REASONS:
        record = written(reason)
        assert RECORD.dump_python(RECORD.validate_python(record, strict=False), mode="json") == record
    kinds = set(RECORD.json_schema()["discriminator"]["mapping"])
    assert kinds == {kind.kind for kind in NoPath.__args__} == {reason.kind for reason in REASONS}


@pytest.mark.parametrize("reason", REASONS, ids=lambda reason: reason.kind)
def test_a_record_that_lacks_a_key_or_is_of_another_kind_is_refused(reason: NoPath) -> None:
    record = written(reason)
    spoilt = [{key: value for key, value in record.items() if key != left_out} for left_out in record]
    for bad in [*spoilt, {**record, "kind": "touching"}]:
        with pytest.raises(pydantic.ValidationError):
            RECORD.validate_python(bad)
