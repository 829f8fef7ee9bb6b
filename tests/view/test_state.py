"""A robot at one configuration: every pair that touches, its clearance and limits, and the sentence about it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.collision import make_checker
from planner.kinematics.manipulability import manipulability
from planner.robot.poses import pose
from planner.robot.shapes import Sphere
from planner.view.state import inspect_state
from tests.browser import page_data
from tests.coal_judge import CoalWorld
from tests.worlds import load, random_q, scene_of

ROBOT = load("planar_2r")
BALLS = scene_of((Sphere(0.2), pose([0.6, 0.2, 0])), (Sphere(0.1), pose([-0.5, -0.3, 0])))


@pytest.mark.parametrize("margin", [0.0, 0.05])
def test_contacts_and_clearance_are_coals(margin: float) -> None:
    checker = make_checker(ROBOT, BALLS, margin=margin)
    coal, movable = CoalWorld(checker.world), checker.world.pair_reach.any(axis=1)
    for q in random_q(ROBOT, 12):
        report = inspect_state(checker, q)
        apart = coal.distances(q)
        if np.abs(apart - margin).min() < 1e-3:
            continue
        assert set(report.contacts) == {checker.world.contact(int(pair)) for pair in np.flatnonzero(apart <= margin)}
        assert report.clearance == pytest.approx(max(0.0, apart[movable].min()), abs=1e-4)
        assert report.w == pytest.approx(manipulability(ROBOT, q[None])[0])
        assert report.sentence.startswith("'" if report.contacts else "Free and within")


def test_limits_are_named_next_to_contacts(tmp_path: Path) -> None:
    checker = make_checker(ROBOT, BALLS)
    report = inspect_state(checker, np.array([0.3, 3.0]))
    assert report.outside == ("joint_2",)
    assert report.sentence.endswith("out of limits: joint_2.")
    assert report.contacts
    report = replace(report, tool=np.array([-1e-9, 0.25, -0.5]))
    (tmp_path / "state.html").write_text(report.page())
    data = page_data(tmp_path / "state.html")
    assert ["tool (m)", "0.000, 0.250, -0.500"] in data["paths"][0]["numbers"]
    assert str(report.sentence) in str(data).replace('"', "'") or report.sentence.split("'")[1] in str(data)
