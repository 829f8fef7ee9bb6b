"""Reasons: plain data for files, the names that a page draws red, and sentences with a remedy."""

import json
from typing import get_type_hints

import pydantic
import pytest

from planner.base.errors import Reason
from planner.planning.record import PlanRecord
from planner.problem import outcome
from planner.problem.outcome import (
    BeyondLimit,
    BlockedInTime,
    BudgetSpent,
    CannotFollow,
    ConstraintBroken,
    ConstraintsTooNarrow,
    FloorTooHigh,
    Gap,
    NoPath,
    OutOfReach,
    Separated,
    Touching,
)

NEAR = Gap(0.12345, (0.0, 1.0), (0.1, 1.0), ("hand", "shelf"))
TOUCHING = Touching("goal", "hand", "shelf", enclosed=False)
EVERY = [
    TOUCHING,
    BeyondLimit("start", "elbow", 3.0, -2.0, 2.0),
    ConstraintBroken("goal", "axis:z,0,0,1,0.1", 0.25),
    OutOfReach("goal", 0.25),
    Separated(("wall", "door"), NEAR),
    BudgetSpent(300, NEAR),
    FloorTooHigh(0.3, 0.2),
    ConstraintsTooNarrow(("axis:z,0,0,1,0.1",), NEAR),
    BlockedInTime("route", ("cart", "lorry")),
    CannotFollow(3, 0.25, "touching", between=("hand", "shelf")),
]


def test_every_reason_is_plain_data_under_a_kind_of_its_own() -> None:
    kinds = {kind for kind in vars(outcome).values() if isinstance(kind, type) and issubclass(kind, Reason)}
    assert kinds - {Reason} == {type(reason) for reason in EVERY}
    written = [json.loads(json.dumps(reason.to_dict())) for reason in EVERY]
    assert len({record["kind"] for record in written}) == len(EVERY)
    assert written[0] == {"kind": "touching", "role": "goal", "first": "hand", "second": "shelf", "enclosed": False}
    assert written[4]["gap"] == {
        "joint_distance": 0.12345,
        "start_side": [0.0, 1.0],
        "goal_side": [0.1, 1.0],
        "between": ["hand", "shelf"],
    }


def test_every_reason_for_no_path_is_a_sentence_with_its_names() -> None:
    for reason in (each for each in EVERY if isinstance(each, NoPath)):
        assert all(name in reason.sentence for name in reason.names)
    assert EVERY[0].names == {"hand", "shelf"}
    assert Separated(("wall", "door"), NEAR).names == {"wall", "door"}


def test_reading_returns_the_written_reason() -> None:
    annotation = pydantic.TypeAdapter(get_type_hints(PlanRecord, include_extras=True)["reason"])
    for reason in (each for each in EVERY if isinstance(each, NoPath)):
        written = json.loads(json.dumps(reason.to_dict()))
        assert annotation.validate_python(written) == reason
        needed = written.keys() - {"distance", "between", "reachable", "cone", "leg"}
        spoilt = [{key: value for key, value in written.items() if key != left_out} for left_out in needed]
        lists = [key for key in ("obstacles", "conditions") if key in written]
        for bad in [*spoilt, {**written, "kind": "touching"}, *({**written, key: []} for key in lists)]:
            with pytest.raises(pydantic.ValidationError):
                annotation.validate_python(bad)
