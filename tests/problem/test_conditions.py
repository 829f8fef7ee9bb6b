"""The grammar of conditions: texts that stand for themselves, and texts that are refused in one sentence."""

import pytest

from planner.base.errors import OptionError
from planner.problem.conditions import (
    AxisConstraint,
    BoxConstraint,
    OrientationConstraint,
    parse_condition,
    parse_constraints,
    read_conditions,
)
from planner.problem.request import PlanRequest
from planner.problem.targets import ToolGoal, parse_target, parse_targets

TEXTS = [
    "axis:z,0,0,1,0.1",
    "axis:x,0,-1,0.5,0.1 of hand",
    "box:-0.5,-0.5,0.2,0.9,0.9,1.5",
    "box:-0.5,-0.5,0.2,0.9,0.9,1.5 of hand at 0,0,0.1",
    "plane:0,0,1,0.3 at 0,0,0.1",
    "turn:0.1",
    "turn:0.1,0,0,0,1 of hand",
]


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_is_parsed_to_a_constraint_with_that_text(text):
    assert parse_condition(text).text == text
    assert parse_condition(f"  {text} ") == parse_condition(text)


def test_lists_and_things_are_as_good_as_texts():
    both = "turn:0.1;box:0,0,0,1,1,1"
    assert (
        read_conditions([OrientationConstraint(0.1), "box:0,0,0,1,1,1"])
        == read_conditions(both)
        == parse_constraints(both)
    )
    assert parse_constraints(both) == (OrientationConstraint(0.1), BoxConstraint((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    assert PlanRequest.from_options(constraint=OrientationConstraint(0.1)).what.constraint == (
        OrientationConstraint(0.1),
    )
    assert PlanRequest.from_options(constraint="").what.constraint == ()


REFUSED = [
    *("turn:", "turn:0.1,0,0", "turn:0.1,0,0,0,2", "turn:10", "turn:nan", "turn:0.00001", "turn:-0.1", "upright"),
    *("axis:z,0,0,1,0.1,5", "axis:q,0,0,1,0.1", "axis:z,0,0,0,0.1", "axis:z,0,0,1,0.1 at 0,0,1", "axis:z,0,0,1,4"),
    *("plane:0,0,0,1", "plane:0,0,1,1e9", "box:0,0,0,1,1,-1", "box:0,0,0,1,1,1 at 1,2", "sphere:0,0,0,1", "cone:1,2"),
]


@pytest.mark.parametrize("text", REFUSED)
def test_a_wrong_constraint_is_refused_in_one_sentence(text):
    with pytest.raises(OptionError, match=r"^[^\n]+\.$"):
        parse_constraints(text)


def test_goals_with_tolerance_are_conditions_too():
    goal = parse_target("xyz:0.5,0.3,0.6 & axis:z,0,0,-1")
    assert goal == ToolGoal((BoxConstraint((0.5, 0.3, 0.6), (0.5, 0.3, 0.6)), AxisConstraint("z", (0.0, 0.0, -1.0))))
    assert parse_target("pose:0.5,0.3,0.6,0,0,0,1&turn:0.1") == ToolGoal(
        (
            BoxConstraint((0.5, 0.3, 0.6), (0.5, 0.3, 0.6)),
            OrientationConstraint(0.0, quaternion=(0.0, 0.0, 0.0, 1.0)),
            OrientationConstraint(0.1),
        )
    )
    texts = [goal.text for goal in parse_targets("home; xyz:0,0,1 & turn:0.1,0,0,0,1;turn:0.1")]
    assert texts == ["home", "xyz:0,0,1 & turn:0.1,0,0,0,1", "turn:0.1"]
    for wrong in ("home & turn:0.1", "xyz:1,2,3 & ", "joint elbow:0,1"):
        with pytest.raises(OptionError):
            parse_target(wrong)
