"""What is said of a checked trajectory: the first reason not to run it, with joint, number and moment."""

from __future__ import annotations

import json

import pytest

from planner.problem.request import LimitsRequest
from planner.trajectory.limits import MotionLimits
from planner.trajectory.report import floor_text, report_record, report_rows, verdict_sentence
from tests.trajectory.test_check import ARM, report_of

STILL = [[-0.3, 0.0], [-0.3, 0.0]]
CASES = {
    "usable": (([0.0, 4.0], STILL), "Free and within all limits"),
    "times": (([0.0, 0.0], STILL), "Not usable: time does not increase from point 1"),
    "degrees": (([0.0, 9.0], [[0.0, 0.0], [90.0, 0.0]]), "Not usable: positions are beyond the joint limits"),
    "a limit": (([0.0, 4.0], [[-0.3, 0.0], [-0.3, 3.5]]), "Not usable: joint 'joint_2' is at 3.5"),
    "too quick": (([0.0, 0.1], [[-0.3, 0.0], [-0.6, 0.0]]), "Not usable: joint 'joint_1' reaches 3 rad/s of velocity"),
    "a contact": (([0.0, 9.0], [[-0.3, 0.0], [1.0, 0.0]]), "Not usable: 'link"),
}


@pytest.mark.parametrize("name", CASES)
def test_the_first_reason_is_named(name: str) -> None:
    (times, rows), words = CASES[name]
    report = report_of(times, rows)
    assert verdict_sentence(report).startswith(words), verdict_sentence(report)
    assert report.ok == (name == "usable")


@pytest.mark.parametrize("name", CASES)
def test_the_record_is_plain_data_that_says_the_same(name: str) -> None:
    (times, rows), _ = CASES[name]
    report = report_of(times, rows)
    record = report_record(report)
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert record["ok"] == report.ok
    assert record["points"] == 2
    assert (record.get("contact") is not None) == (name == "a contact")
    assert {excess["kind"] for excess in record.get("exceeded", [])} == {
        "a limit": {"position"},
        "too quick": {"velocity"},
    }.get(name, set())
    assert dict(report_rows(report))["trajectory"].startswith("2 points")


@pytest.mark.parametrize(
    ("above", "exempt", "below", "text"),
    [
        (40, 0, 0, "w is proven above the floor of 0.15 in 40 of 40 pieces"),
        (
            40,
            12,
            0,
            "above the floor of 0.15 in 40 of 52 pieces; the other 12 lead up from its start or down to its goal",
        ),
        (40, 12, 1, "w is NOT proven above the floor of 0.15 in 1 of 53 pieces"),
        (0, 53, 0, "nothing is proven of w: it never stays above the floor of 0.15 from one of 53 pieces to the next"),
    ],
)
def test_what_is_proven_of_a_floor_is_said_by_its_three_counts(above: int, exempt: int, below: int, text: str) -> None:
    counts = {"pieces_above": above, "pieces_exempt": exempt, "pieces_below": below}
    assert floor_text({"asked": 0.15, **counts}).endswith(text)


def test_where_something_jumps_there_is_no_share() -> None:
    shares = report_record(report_of([0.0, 4.0], STILL))["shares"]
    assert shares == {"velocity": 0.0, "acceleration": 0.0, "jerk": 0.0}
    moves = report_record(report_of([0.0, 4.0], [[-0.3, 0.0], [-0.3, 0.4]]))
    assert moves["shares"] == {"velocity": pytest.approx(0.05), "acceleration": None, "jerk": None}
    assert moves["not_judged"] == ["acceleration", "jerk"]
    assert moves["jump"] == {"what": "velocity", "joint": "joint_2", "size": 0.1, "time": 4.0, "count": 1}


@pytest.mark.parametrize(
    ("rows", "limits", "kind", "words"),
    [
        (
            [[[-0.3, 0.0], [-0.3, 0.5], [-0.3, 0.5]]],
            LimitsRequest(acceleration=5.0),
            "acceleration",
            "jumps by 0.5 rad/s at 1.000 s: an infinite acceleration where the limit is 5 rad/s²; give velocities too",
        ),
        (
            [[[-0.3, 0.0], [-0.3, 0.2], [-0.3, 0.2]], [[0.0, 0.0]] * 3],
            LimitsRequest(jerk=500.0),
            "jerk",
            "(the largest of 2 jumps): an infinite jerk where the limit is 500 rad/s³; give accelerations too",
        ),
    ],
    ids=["lines", "cubics"],
)
def test_a_jump_is_beyond_every_limit_that_somebody_gives(
    rows: list, limits: LimitsRequest, kind: str, words: str
) -> None:
    """And where it is assumed for want of any, the report says that it was not judged."""
    judged = report_of([0.0, 1.0, 2.0], *rows, limits=MotionLimits.of(ARM, limits))
    assert not judged.ok
    assert words in verdict_sentence(judged)
    record = report_record(judged)
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert (kind, None) in [(excess["kind"], excess["value"]) for excess in record["exceeded"]]
    left_open = report_of([0.0, 1.0, 2.0], *rows)
    assert left_open.ok
    assert "all limits" not in verdict_sentence(left_open)
    assert f"{kind}" in verdict_sentence(left_open).split("; ")[-1]
    assert "not judged" in verdict_sentence(left_open)
    assert "not judged" in dict(report_rows(left_open))[kind]


def test_how_it_begins_is_told() -> None:
    late = report_of([0.5, 4.0], STILL)
    assert report_record(late)["notes"] == ["until 0.5 s it moves there from where the robot is: that is not checked"]
    moving = report_of([0.0, 4.0], STILL, [[0.0, 0.2], [0.0, 0.0]])
    assert "joint 'joint_2' begins with a velocity of 0.2" in dict(report_rows(moving))["note"]
