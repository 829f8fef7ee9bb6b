"""What the live page may ask for: checked data, and nothing else."""

from __future__ import annotations

import json
from typing import Any

import pytest

from planner.base.errors import PlannerError
from planner.base.yamlfile import validate
from planner.live.messages import MoveGoal, MoveObstacle, Reload, Request, Save, SetBeta, SetStart, Undo

ORDERS: dict[type, tuple[dict[str, Any], str | None]] = {
    MoveObstacle: (
        {"do": "move", "name": "post", "position": [1.0, 2.0, 3.0], "quaternion": [0, 0, 0, 1]},
        "obstacle 'post' moved",
    ),
    MoveGoal: ({"do": "goal", "position": [0.1, 0.2, 0.3]}, "goal moved"),
    SetStart: ({"do": "start", "joints": [0.5, -0.5]}, "start set"),
    SetBeta: ({"do": "beta", "beta": 0.25}, "beta set"),
    Undo: ({"do": "undo"}, None),
    Save: ({"do": "save"}, None),
    Reload: ({"do": "reload"}, "scene read again"),
}


def parsed(order: object) -> Any:
    """The order as it comes over the wire."""
    return validate(Request, json.loads(json.dumps({"order": order})), "the request", PlannerError).order


@pytest.mark.parametrize("kind", ORDERS)
def test_an_order_is_known_by_what_it_does(kind: type) -> None:
    asked, what = ORDERS[kind]
    order = parsed(asked)
    assert type(order) is kind
    assert json.loads(order.model_dump_json()) == asked
    assert getattr(order, "what", None) == what


@pytest.mark.parametrize("kind", ORDERS)
def test_no_key_may_be_missing_or_come_with_others(kind: type) -> None:
    asked, _ = ORDERS[kind]
    spoilt = [{key: value for key, value in asked.items() if key != left_out} for left_out in asked]
    for bad in [*spoilt, {**asked, "file": "/etc/passwd"}]:
        with pytest.raises(PlannerError, match=r"^the request: .*\.$"):
            parsed(bad)


@pytest.mark.parametrize(
    ("kind", "key", "value"),
    [
        (MoveObstacle, "position", [0.0, 0.0]),
        (MoveObstacle, "position", [0.0, 0.0, float("nan")]),
        (MoveObstacle, "position", [1e9, 0.0, 0.0]),
        (MoveObstacle, "quaternion", [0, 0, 1]),
        (MoveObstacle, "name", "x" * 1001),
        (MoveGoal, "position", [0.0, 0.0, float("inf")]),
        (SetStart, "joints", [0.0] * 1001),
        (SetStart, "joints", ["elbow"]),
        (SetBeta, "beta", -0.001),
        (SetBeta, "beta", 1.001),
        (Undo, "do", "format the disk"),
    ],
)
def test_values_out_of_range_name_their_key(kind: type, key: str, value: object) -> None:
    asked, _ = ORDERS[kind]
    with pytest.raises(PlannerError) as refused:
        parsed({**asked, key: value})
    assert (key if key != "do" else "format the disk") in str(refused.value)


def test_the_ends_of_the_range_of_beta_are_in_it() -> None:
    assert [parsed({"do": "beta", "beta": beta}).beta for beta in (0, 1)] == [0.0, 1.0]
