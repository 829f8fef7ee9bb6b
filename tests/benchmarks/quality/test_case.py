"""One run of the benchmark of path quality: ours and OMPL's are measured alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.quality.case import OURS, measure
from planner.batch.outcomes import REFUSED
from planner.paths.measure import path_manipulability
from planner.planning.plan import plan
from planner.problem.request import PlanRequest
from tests.worlds import make_post

REQUEST = PlanRequest(
    "planar_2r", make_post().world.scene, start="q:-1,0.8", goal="q:1,-0.8", nodes=40, collision="coal", effort=1
)


def test_our_own_row_is_the_plan() -> None:
    columns, found = measure(OURS, REQUEST, 0.0), plan(REQUEST)
    assert found.cost is not None
    w = path_manipulability(found.robot, found.path)
    steps = np.linalg.norm(np.diff(found.path, axis=0), axis=1)
    assert columns["cost"] == pytest.approx(found.cost.total)
    assert columns["lower_bound"] <= columns["cost"]
    assert columns["length_rad"] == pytest.approx(steps.sum())
    assert columns["straight_rad"] <= columns["length_rad"]
    assert columns["w_min"] == pytest.approx(w.min())
    assert columns["dips"] is bool(w.min() < (1 - 1e-6) * min(w[0], w[-1]))


def test_ompls_row_has_the_same_measures() -> None:
    columns = measure("RRTConnect", REQUEST, 1.0)
    assert set(columns) == set(measure(OURS, REQUEST, 0.0)) - {"cost", "lower_bound"}
    assert columns["length_rad"] >= columns["straight_rad"]


def test_what_is_refused_is_a_row() -> None:
    columns = measure(OURS, replace(REQUEST, goal="q:9,9"), 0.0)
    assert columns["outcome"] == REFUSED
    assert "joint_1" in columns["message"]
