"""Reasons: plain data for files, the names that a page draws red, and sentences with a remedy."""

from __future__ import annotations

import json
from typing import Literal, get_type_hints

import pydantic
import pytest

from planner.base.errors import Reason
from planner.planning.record import PlanRecord
from planner.problem import reasons
from planner.problem.reasons import (
    BeyondLimit,
    BlockedInTime,
    BreaksKept,
    BudgetSpent,
    CannotFollow,
    FloorTooHigh,
    Gap,
    KeptTooNarrow,
    NoPath,
    OutOfReach,
    Separated,
    Touching,
)

NEAR = Gap(0.12345, (0.0, 1.0), (0.1, 1.0), ("hand", "shelf"))
UNSTOPPED = Gap(2.0, (0.0,), (2.0,), None)
TOUCHING = Touching("goal", "hand", "shelf", enclosed=False)
EVERY = [
    TOUCHING,
    BeyondLimit("start", "elbow", 3.0, -2.0, 2.0),
    BreaksKept("goal", "axis:z,0,0,1,0.1", 0.25),
    OutOfReach("goal", 0.25),
    Separated(("wall", "door"), NEAR),
    BudgetSpent(300, NEAR),
    FloorTooHigh(0.3, 0.2),
    KeptTooNarrow(("axis:z,0,0,1,0.1",), NEAR),
    BlockedInTime("route", ("cart", "lorry")),
    CannotFollow(3, 0.25, "touching", between=("hand", "shelf")),
]


def test_every_reason_is_plain_data_under_a_kind_of_its_own() -> None:
    kinds = {kind for kind in vars(reasons).values() if isinstance(kind, type) and issubclass(kind, Reason)}
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


def test_what_is_written_of_a_reason_for_no_path_reads_as_the_same_reason() -> None:
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


@pytest.mark.parametrize(
    ("reason", "names"),
    [
        (TOUCHING, {"hand", "shelf"}),
        (Separated(("wall", "door"), NEAR), {"wall", "door"}),
        (BudgetSpent(300, NEAR), {"hand", "shelf"}),
        (BudgetSpent(300, UNSTOPPED), set()),
        (FloorTooHigh(0.3, 0.2), set()),
        (OutOfReach("goal", 0.25), set()),
        (BlockedInTime("route", ("cart", "lorry")), {"cart", "lorry"}),
        (CannotFollow(3, 0.25, "touching", between=("hand", "shelf")), {"hand", "shelf"}),
        (CannotFollow(3, 0.25, "beyond_limit", between=("elbow",)), set()),
    ],
)
def test_the_names_that_are_blamed(reason: Reason, names: set[str]) -> None:
    assert reason.names == names


def test_how_near_the_parts_came() -> None:
    assert NEAR.sentence.endswith("within 0.123 rad of each other, where 'hand' and 'shelf' come too near")
    assert UNSTOPPED.sentence.endswith("within 2 rad of each other")


def test_one_obstacle_separates_and_two_do_so_together() -> None:
    one, two = Separated(("wall",), NEAR).sentence, Separated(("wall", "door"), NEAR).sentence
    assert "'wall' separates them (without it they are joined)" in one
    assert one.endswith("come too near: move it, raise --nodes, or try another --seed.")
    assert "'wall', 'door' together separate them (without them they are joined)" in two
    assert "move one of them, raise" in two


def test_a_spent_budget_names_its_nodes_and_blames_no_obstacle() -> None:
    sentence = BudgetSpent(300, UNSTOPPED).sentence
    assert "budget of 300 nodes: their parts of the roadmap came within 2 rad" in sentence
    assert sentence.endswith("raise --nodes, or try another --seed.")


def test_a_floor_that_is_too_high_names_one_that_is_not() -> None:
    assert "--min-manipulability 0.2 or less, raise --nodes" in FloorTooHigh(0.3, 0.2).sentence
    none = FloorTooHigh(0.3, 0.0).sentence
    assert "floor of 0.3 " in none
    assert none.endswith("leave --min-manipulability out.")


@pytest.mark.parametrize(
    ("place", "end"), [("start", "choose another start."), ("goal", "choose another goal."), ("route", "--seed.")]
)
def test_what_moves_in_the_way_is_named_with_a_remedy(place: Literal["start", "goal", "route"], end: str) -> None:
    sentence = BlockedInTime(place, ("cart", "lorry")).sentence
    assert "not in time" in sentence
    assert "'cart', 'lorry'" in sentence
    assert sentence.endswith(end)


@pytest.mark.parametrize(
    ("reason", "part"),
    [
        (CannotFollow(3, 0.25, "out_of_reach", 0.1), "no nearer than 0.1 m"),
        (CannotFollow(3, 0.25, "turned", 0.2), "turned away by 0.2 rad"),
        (CannotFollow(3, 0.25, "beyond_limit", between=("elbow",)), "limits of elbow"),
        (CannotFollow(3, 0.25, "touching", between=("hand", "shelf")), "'hand' and 'shelf' come too near"),
        (CannotFollow(3, 0.25, "below_floor", reachable=0.02), "highest found that it keeps to is 0.02"),
        (CannotFollow(3, 0.25, "jump", 1.5), "1.5 rad apart"),
    ],
)
def test_why_a_tool_path_is_not_followed(reason: CannotFollow, part: str) -> None:
    assert reason.sentence.startswith("The tool path can be followed over 25.0 %, not to point 3: ")
    assert part in reason.sentence
    assert reason.sentence.endswith(".")
