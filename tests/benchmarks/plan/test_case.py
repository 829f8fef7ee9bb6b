"""One run of a planning problem."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.plan.case import measure, path_contacts
from benchmarks.problems import find_problems
from planner.batch.outcomes import NO_PATH
from planner.collision import make_checker
from planner.paths.measure import joint_path_length
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from tests.batch.posts import PLAIN
from tests.benchmarks.plan.test_run import rows_of
from tests.worlds import POST_GOAL, POST_START, load, make_post


def test_no_path_is_no_crash(tmp_path: Path) -> None:
    trap = tmp_path / "trap.yaml"
    trap.write_text(
        "obstacles:\n"
        "  - {name: left, type: box, size: [0.02, 0.6, 0.4], position: [0.0, 0.5, 0.0]}\n"
        "  - {name: right, type: box, size: [0.02, 0.6, 0.4], position: [0.0, -0.5, 0.0]}\n"
    )
    columns = measure(PlanRequest("planar_2r", str(trap), start="q:0,0", goal="q:3.1,0", nodes=30, collision="coal"))
    assert columns["outcome"] == NO_PATH
    assert columns["nodes"] >= 2
    assert "length_rad" not in columns


def test_contacts_are_counted_by_the_segment() -> None:
    """Straight across the post, twice: two segments touch, the way between them does not."""
    other = make_checker(load("planar_2r"), make_post().world.scene, "coal")
    across = np.array([POST_START * [1, 0], POST_GOAL * [1, 0]])
    path = np.vstack([across, across[1] + [0.1, 0], across[0]])
    found = path_contacts(other, path)
    assert [text.split(" at ")[0] for text in found] == ["segment 0", "segment 2"]
    assert "'post'" in found[0] or "thing0" in found[0]
    assert path_contacts(other, path[:1]) == []
    assert path_contacts(other, np.array([[0.0, 0.0]]))[0].startswith("segment 0 at 0")


def test_a_row_is_the_plan(problems: Path, out: Path) -> None:
    """Length, w and clearance of the row against the same plan made here."""
    row = rows_of(out)[3]
    problem = find_problems(problems)[1]
    made = plan(replace(PLAIN, scene=str(problem.scene), motion_plan_request=problem.request, seed=1))
    assert row.length_rad == pytest.approx(joint_path_length(made.path))
    assert row.waypoints == len(made.path)
    assert row.edges == len(made.roadmap.edges)
    assert row.w_min is not None
    assert row.w_mean is not None
    elbow = np.abs(np.sin(made.path[:, 1]))  # a planar arm's w is l1 l2 |sin q2|
    assert row.w_min <= 0.5 * 0.4 * elbow.min() + 1e-9
    assert 0 < row.w_min < row.w_mean
    assert row.clearance_m is not None
    assert row.clearance_m > 0
