"""The report on a checked path."""

from __future__ import annotations

import json

import numpy as np

from planner.planning.result import Plan
from planner.trajectory.path_check import check_path
from planner.trajectory.path_report import excess_text, report_record, report_rows, verdict_sentence
from tests.worlds import checker_of, make_post


def test_the_record_is_plain_data(solved: Plan) -> None:
    for checker in (solved.checker, checker_of("iiwa14", "empty")):
        record = report_record(check_path(checker, solved.path))
        assert json.loads(json.dumps(record, allow_nan=False)) == record
        assert record["ok"] is True
        assert record["segments"] == {"free": len(solved.path) - 1, "collides": 0, "undecided": 0}
        assert len(record["manipulability"]["profile"]) == 101
        assert min(record["manipulability"]["profile"]) >= record["manipulability"]["min"]


def test_what_is_wrong_is_the_first_thing_said() -> None:
    checker = make_post()
    robot = checker.robot
    for path, words in (
        ([[-1.0, 0.8], [1.0, 0.8]], "Not usable: 'link"),
        ([[-1.0, 0.8], [-1.0, 3.5]], "Not usable: waypoint 2 puts joint 'joint_2' at 3.5"),
        ([[-1.0, 0.8], [-1.0, 90.0]], "degrees"),
    ):
        report = check_path(checker, np.array(path))
        assert words in verdict_sentence(report)
        assert report_record(report)["ok"] is False
        assert dict(report_rows(report))["joint limits"] == (
            "within limits" if "link" in words else excess_text(robot, report.excess)  # type: ignore[arg-type]
        )


def test_the_place_of_a_contact_is_told_with_its_configuration() -> None:
    report = check_path(make_post(), np.array([[-1.0, 0.8], [1.0, 0.8]]))
    assert report.contact is not None
    rows = dict(report_rows(report))
    assert f"in segment 1 at {100 * report.contact.share:.1f} %" in rows["first contact"]
    assert "q:" + ",".join(f"{value:.4f}" for value in report.contact.q) in rows["first contact"]
    assert rows["path"].startswith("2 waypoints, 2.000 rad")
    record = report_record(report)["contact"]
    assert record["q"] == report.contact.q.tolist()
    assert record["pair"] == [report.contact.contact.first, report.contact.contact.second]
