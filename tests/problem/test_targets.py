"""Targets as people write them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import OptionError, StateError
from planner.problem.targets import Joints, Named, Pose, Position, follow, parse_target, parse_targets
from tests.random_shapes import QUICK

NUMBERS = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=9)


@pytest.mark.parametrize(
    ("text", "target"),
    [
        ("start", Named(("start",))),
        (" home ", Named(("home",))),
        ("left, right", Named(("left", "right"))),
        ("q:0.1,-0.4", Joints((0.1, -0.4))),
        ("q: 1 , 2e-1", Joints((1.0, 0.2))),
        ("xyz:0.92,-0.10,0.42", Position((0.92, -0.10, 0.42))),
        ("pose:1,2,3,0,0,0,1", Pose((1, 2, 3), (0, 0, 0, 1))),
    ],
)
def test_forms(text, target):
    assert parse_target(text) == target


def test_goals_of_equal_right():
    assert parse_targets("goal") == (Named(("goal",)),)
    assert parse_targets("xyz:1,2,3 ; left, right;q:1") == (
        Position((1, 2, 3)),
        Named(("left",)),
        Named(("right",)),
        Joints((1.0,)),
    )
    with pytest.raises(OptionError, match="empty state"):
        parse_targets("goal;")


@QUICK
@given(NUMBERS)
def test_numbers_come_back_to_the_last_bit(values):
    assert parse_target("q:" + ",".join(map(repr, values))) == Joints(tuple(values))


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("", ["empty state", "q:...", "xyz:x,y,z"]),
        ("joints:1,2", ["'joints:1,2'", "'joints:'", "a name from the scene", "pose:x,y,z,qx,qy,qz,qw"]),
        ("q:", ["'q:'", "no number"]),
        ("q:1,two", ["'q:1,two'", "no number"]),
        ("xyz:1,2", ["has 2 numbers and must have 3"]),
        ("pose:1,2,3", ["has 3 numbers and must have 7"]),
    ],
)
def test_refused(text, parts):
    with pytest.raises(OptionError) as caught:
        parse_target(text)
    assert [part for part in parts if part not in str(caught.value)] == []
    assert caught.value.exit_code == 2
    assert str(caught.value).endswith(".")


@QUICK
@given(st.text(max_size=30))
def test_any_text_is_a_target_or_an_option_error(text):
    try:
        target = parse_target(text)
    except OptionError:
        return
    assert isinstance(target, Joints | Position | Pose | Named)


def test_names_of_names_end():
    states = {"a": "b", "b": "q:1,2", "c": "a,b,home", "x": "y", "y": "x", "me": "me"}
    assert follow("c", states) == ["q:1,2", "q:1,2", "home"]
    assert follow("home", states) == ["home"]
    for name in ("x", "me"):
        with pytest.raises(StateError, match="leads back to itself"):
            follow(name, states)
