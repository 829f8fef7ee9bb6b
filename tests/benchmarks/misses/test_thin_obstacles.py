"""Thin obstacles between free ends."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.misses.thin_obstacles import KINDS, thin_case
from planner.collision import make_checker
from planner.models.scene import Scene
from planner.models.shapes import Box
from tests.worlds import load


@pytest.mark.parametrize("kind", KINDS)
def test_cases_are_thin_and_their_ends_are_free(kind: str) -> None:
    robot = load("iiwa14")
    case = thin_case(make_checker(robot, Scene("empty"), "coal"), kind, 0.003, np.random.default_rng(4))
    for item in case.scene.obstacles:
        size = np.array(item.shape.size) if isinstance(item.shape, Box) else np.array([2 * item.shape.radius])  # type: ignore[union-attr]
        assert size.min() == pytest.approx(0.003)
    assert len(case.scene.obstacles) == {"wall": 1, "pole": 1, "window": 4}[kind]
    checker = make_checker(robot, case.scene, "fcl")
    assert checker.first_contact(np.vstack([case.start, case.start + case.delta])) is None
    for q in (case.start, case.start + case.delta):
        assert ((q >= robot.lower) & (q <= robot.upper)).all()
