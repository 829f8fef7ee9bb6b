"""A planar arm's own geometry and w against the planner's collision library and kinematics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.optimum.arms import ARMS, PlanarArm, segment_to_box
from planner.collision import make_checker
from planner.kinematics.manipulability import manipulability
from planner.models.robot import Robot


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_geometry_and_w_are_those_of_the_robot(arm: PlanarArm, tmp_path: Path) -> None:
    robot = Robot.load(str(arm.robot_in(tmp_path)))
    checker = make_checker(robot, arm.scene, "coal")
    q = np.random.default_rng(0).uniform(-arm.limits, arm.limits, (400, len(arm.start)))
    q = np.vstack([arm.start, arm.goal, q])
    np.testing.assert_allclose(manipulability(robot, q), arm.manipulability(q), atol=1e-9)
    clear = arm.clearance(q)
    assert clear[:2].min() > 0
    assert (clear < 0).any()
    for state, far in zip(q, clear, strict=True):
        touches = checker.first_contact(state[None]) is not None
        assert touches == (far < 0) or abs(far) < 1e-5


def test_distances_to_a_rectangle_are_those_of_many_points() -> None:
    rng, box = np.random.default_rng(1), np.array([0.1, -0.2, 0.5, 0.3])
    a, b = rng.uniform(-1, 1, (2, 200, 2))
    points = a[:, None] + np.linspace(0, 1, 2001)[:, None] * (b - a)[:, None]
    apart = np.linalg.norm(np.maximum(np.abs(points - box[:2]) - 0.5 * box[2:], 0.0), axis=2).min(axis=1)
    np.testing.assert_allclose(segment_to_box(a, b, box), apart, atol=1.5e-3)
