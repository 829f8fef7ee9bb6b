"""``planner bench first-path``: every method is a row, other environments get the same problem, paths are looked at."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from planner.base.errors import OptionError, PlannerError
from planner.base.request import PlanRequest
from planner.collision.checker import is_free
from planner.query.open import make_query
from planner.studies.bench_first_path.exchange import exchanged
from planner.studies.bench_first_path.report import OMPL, OURS, Row, to_markdown
from planner.studies.bench_first_path.run import bench_first_path, environments
from planner.studies.bench_first_path.runner import _pinocchio_models
from planner.studies.bench_plan.rows import REFUSED, SOLVED
from tests.studies.bench_plan.test_run import write_problem
from tests.worlds import random_q

PLAIN = PlanRequest(robot="planar_2r", collision="coal", path_only=True)


def test_every_method_is_a_row_and_none_is_measured_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, out = tmp_path / "posts", tmp_path / "out"
    write_problem(folder, "0001", (-1.0, 0.8), (1.0, -0.8))
    found = bench_first_path(folder, out, PLAIN, {"pyroboplan": sys.executable}, seconds=5.0)
    assert [row.method for row in found.rows] == [OURS, OMPL, "pyroboplan"]
    ours, ompl, other = found.rows
    for row in (ours, ompl):
        assert row.outcome == SOLVED, row.message
        assert row.first_s is not None
        assert row.path_s is not None
        assert 0 < row.first_s <= row.path_s
        assert row.length_rad is not None
        assert row.length_rad >= np.hypot(2.0, 1.6) * (1 - 1e-9)
    assert ours.contacts == 0
    assert other.outcome == REFUSED
    assert "No module named 'pyroboplan" in other.message
    monkeypatch.setattr("planner.studies.bench_first_path.run._measure", lambda *_: [])
    again = bench_first_path(folder, out, PLAIN, {"pyroboplan": sys.executable}, seconds=5.0)
    assert again.rows == found.rows


@pytest.mark.parametrize(("robot", "scene"), [("panda", "shelf"), ("iiwa14", "window"), ("ur5", "window")])
def test_the_problem_that_others_get_is_ours(robot: str, scene: str) -> None:
    """Pinocchio's own collision pairs on the exchanged data, against our checker, on random configurations."""
    query = make_query(PlanRequest(robot, scene, collision="coal"))
    problem = exchanged(query, 0, 1.0)
    model, geometry = _pinocchio_models(problem)
    data, found = model.createData(), geometry.createData()
    np.testing.assert_allclose(model.lowerPositionLimit, query.robot.lower)
    verdicts = []
    for q in [*random_q(query.robot, 60, 3), query.starts[0], query.goals[0]]:
        free = is_free(query.checker, q)
        assert free == (not pin.computeCollisions(model, data, geometry, found, q, True))
        verdicts.append(free)
    assert len(set(verdicts)) == 2


def test_what_others_cannot_be_told_is_refused() -> None:
    with pytest.raises(PlannerError, match="capsule or a mesh"):
        exchanged(make_query(PlanRequest(collision="coal")), 0, 1.0)
    with pytest.raises(PlannerError, match="carried shapes"):
        exchanged(make_query(PlanRequest(scene="gcs", collision="coal")), 0, 1.0)


@pytest.mark.parametrize("text", ["roboplan", "roboplan=/nowhere/python", f"vamp={sys.executable}"])
def test_environments_are_a_name_and_a_python(text: str) -> None:
    assert environments([f"roboplan={sys.executable}"]) == {"roboplan": sys.executable}
    with pytest.raises(OptionError, match="give NAME=PATH, a planner of roboplan, pyroboplan"):
        environments([text])


def test_the_report_counts_paths_that_touch() -> None:
    def row(problem: str, method: str, **more: float) -> Row:
        return Row(problem, method, 0, "panda", "coal", 1.0, "", "", SOLVED, "here", first_s=0.1, path_s=0.2, **more)  # type: ignore[arg-type]

    report = to_markdown([row("a", OURS, contacts=0), row("a", OMPL, contacts=3), row("b", OMPL, contacts=0)])
    assert "| planner | 1 | 1 |" in report
    assert "| 1 of 2 | none |" in report
    assert "- 1 of 1: No path of ours touches anything." in report
    assert "- 0 of 1: Our first proven path" in report
    assert "a, OMPL RRTConnect, plain coal touches: here." in report
