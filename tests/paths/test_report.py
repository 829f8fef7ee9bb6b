"""The report on a checked path."""

from __future__ import annotations

import json

from planner.paths.check import check_path
from planner.paths.report import report_record
from planner.plan_record import Plan
from tests.worlds import checker_of


def test_the_record_is_plain_data(solved: Plan) -> None:
    for checker in (solved.checker, checker_of("iiwa14", "empty")):
        record = report_record(check_path(checker, solved.path))
        assert json.loads(json.dumps(record, allow_nan=False)) == record
        assert record["ok"] is True
        assert record["segments"] == {"free": len(solved.path) - 1, "collides": 0, "undecided": 0}
        assert len(record["manipulability"]["profile"]) == 101
        assert min(record["manipulability"]["profile"]) >= record["manipulability"]["min"]
