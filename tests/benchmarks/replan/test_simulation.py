"""Simulated boxes keep their limits, come for the arm, and touch nothing before the horizon."""

from __future__ import annotations

import numpy as np

from benchmarks.replan.simulation import _draw, _sent, simulate
from planner.collision import make_checker
from planner.models.scene import Scene
from planner.trajectory.trajectory import Trajectory
from tests.worlds import load

MOVING = Trajectory.through(("joint_1", "joint_2"), np.array([0.0, 2.0]), np.array([[-1.0, 0.8], [1.0, -0.8]]))


def test_runs_are_repeatable_and_none_touches_early() -> None:
    checker = make_checker(load("planar_2r"), Scene("none"), "coal")
    found = simulate(checker, MOVING, 6, seed=0)
    assert (found.runs, found.before) == (6, 0)
    assert found.after > 0
    assert found == simulate(checker, MOVING, 6, seed=0)


def test_no_box_is_quicker_than_its_limit() -> None:
    checker, rng = make_checker(load("planar_2r"), Scene("none"), "coal"), np.random.default_rng(0)
    for hunts in (True, False):
        for box in _draw(checker, MOVING, rng):
            moving = _sent(checker, MOVING, box, 3.0, hunts, rng)
            assert moving.motion.speeds(box.shape).max() <= box.speed_limit * (1 + 1e-9)
