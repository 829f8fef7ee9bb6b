"""One task by one method."""

from __future__ import annotations

import pytest

from benchmarks.tables.case import measure
from benchmarks.tables.methods import KEPT, PATH_ONLY, asked_by
from benchmarks.tables.published import GCS
from planner.batch.outcomes import REFUSED, SOLVED
from planner.problem.request import PlanRequest

PLAIN = PlanRequest("iiwa14", GCS, collision="coal", nodes=30, effort=0)


@pytest.mark.parametrize("method", [PATH_ONLY, "beta 1", KEPT])
def test_a_task_by_every_method(method: str) -> None:
    request = asked_by(PLAIN, (1.0,), kept=True)[method]
    (columns,) = measure(method, [("right-bin", "above-shelf")], request)
    assert columns["outcome"] == SOLVED, columns
    assert columns["contacts"] == 0
    assert columns["length_rad"] >= columns["straight_rad"] == pytest.approx(1.66, abs=0.01)
    assert 0 < columns["w_min"] <= columns["w_mean"]
    assert ("built_s" in columns) == (method == KEPT)


def test_a_task_that_is_refused_is_a_row() -> None:
    (columns,) = measure(PATH_ONLY, [("nowhere", "above-shelf")], PLAIN)
    assert columns["outcome"] == REFUSED
    assert "nowhere" in columns["message"]
