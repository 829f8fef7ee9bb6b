"""One problem of the benchmark of motions: its columns, and endings that have none."""

from __future__ import annotations

from dataclasses import replace

from benchmarks.motion.case import REFUSED, measure
from benchmarks.motion.toppra_law import installed
from planner.base.progress import QUIET
from planner.planning.plan import plan
from planner.problem.request import LimitsRequest, PlanRequest
from planner.trajectory.timing import time_path

REQUEST = PlanRequest("planar_2r", "empty", start="q:-1,0.5", goal="q:1,0.9", nodes=40)


def test_the_columns_are_those_of_the_motion() -> None:
    columns = measure(REQUEST, LimitsRequest(), QUIET)
    found = plan(REQUEST)
    motion = time_path(found.path, found.checker, law="shortcuts")
    assert columns["outcome"] == "solved"
    assert columns["blended_s"] == motion.duration
    assert columns["knots"] == len(motion.times)
    assert columns["stopping_s"] >= columns["blended_s"] - 1e-9
    assert columns["proven"] is True
    assert columns["contact"] == ""
    assert 0.9 < columns["largest_share"] <= 1.0 + 1e-6, "some limit is what makes it take that long"
    assert (columns["toppra_s"] is not None) == installed()


def test_what_is_refused_is_a_row() -> None:
    columns = measure(replace(REQUEST, goal="q:9,9"), LimitsRequest(), QUIET)
    assert set(columns) == {"outcome", "message"}
    assert columns["outcome"] == REFUSED
