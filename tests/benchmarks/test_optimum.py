"""``benchmarks optimum``: its plane's geometry is that of the robot, and its grid finds an exact optimum."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.optimum import grid
from benchmarks.optimum.arms import ARMS, TWO_JOINTS, PlanarArm
from benchmarks.optimum.grid import grid_optimum, path_cost
from planner.collision import make_checker
from planner.cost.scale import CostScale
from planner.kinematics.manipulability import manipulability
from planner.robot.robot import Robot

SCALE = CostScale(0.02, 0.2, 1.0, 1.0, 0.01)
HULL = 3.6460  # rad: taut around the states in contact, bisected in 1001 columns; the other side takes 3.6626


def test_the_grid_finds_the_taut_path(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(grid._HALVINGS, 2, 2)  # enough for 0.3 %
    path, error = grid_optimum(TWO_JOINTS, 1.0, SCALE)
    assert path_cost(TWO_JOINTS, 1.0, SCALE, path) == pytest.approx(HULL, rel=3e-3)
    assert error < 3e-3


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_geometry_and_w_are_those_of_the_robot(arm: PlanarArm, tmp_path: Path) -> None:
    robot = Robot.load(str(arm.robot_in(tmp_path)))
    checker = make_checker(robot, arm.scene, "coal")
    q = np.vstack(
        [arm.start, arm.goal, np.random.default_rng(0).uniform(-arm.limits, arm.limits, (400, len(arm.start)))]
    )
    np.testing.assert_allclose(manipulability(robot, q), arm.manipulability(q), atol=1e-9)
    clear = arm.clearance(q)
    assert clear[:2].min() > 0
    assert (clear < 0).any()
    for state, far in zip(q, clear, strict=True):
        assert (checker.first_contact(state[None]) is not None) == (far < 0) or abs(far) < 1e-5
