"""A joint path as the page plays it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planner.base.resolutions import SHOWN_STATES
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.planning.result import Plan
from planner.robot.robot import Robot
from planner.trajectory.measure import dense_path
from planner.trajectory.timing import time_path
from planner.view.motion import (
    ShownPath,
    configurations_at,
    ellipsoids,
    find_worst_points,
    motion_data,
    path_shares,
    sample_motion,
)
from tests.worlds import ROBOTS, checker_of, load, random_q


def test_motion_is_even_in_joint_space(solved: Plan) -> None:
    shares, total = path_shares(solved.path)
    q = configurations_at(solved.path, shares, np.linspace(0, 1, SHOWN_STATES))
    np.testing.assert_array_equal(q[[0, -1]], solved.path[[0, -1]])
    steps = np.linalg.norm(np.diff(q, axis=0), axis=1)
    assert steps.max() <= total / (SHOWN_STATES - 1) * (1 + 1e-9)
    data = motion_data(solved.robot, ShownPath(solved.path, []))
    np.testing.assert_allclose(data["w"], manipulability(solved.robot, q), atol=1e-7)
    np.testing.assert_allclose(data["ellipsoids"][60], ellipsoids(solved.robot, q[[120]])[0], atol=1e-4)


def test_a_motion_is_even_in_time(solved: Plan) -> None:
    trajectory = time_path(solved.path, solved.checker)
    data = motion_data(solved.robot, ShownPath(solved.path, [], motion=sample_motion(trajectory, solved.checker)))
    assert data["seconds"] == data["motion"]["duration"] == trajectory.duration
    q = trajectory.at(np.linspace(0.0, trajectory.duration, SHOWN_STATES))
    np.testing.assert_allclose(data["waypoints"], q, atol=1e-8)
    np.testing.assert_allclose(data["w"], manipulability(solved.robot, q), atol=1e-6)
    motion, step = data["motion"], trajectory.duration / (SHOWN_STATES - 1)
    for kind in ("velocity", "acceleration", "jerk"):
        rates, limits = np.array(motion[kind]), np.array(motion["limits"][kind])
        assert rates.shape == (solved.robot.dof, SHOWN_STATES)
        least = 0.0 if kind == "jerk" else 0.9  # which is short
        assert least < np.abs(rates / limits[:, None]).max() <= 1.0 + 1e-3
    numeric = np.linalg.norm(np.gradient(tool_positions(solved.robot, q), step, axis=0), axis=1)
    np.testing.assert_allclose(motion["tool_speed"][1:-1], numeric[1:-1], atol=0.02)
    np.testing.assert_allclose(data["condition"], np.linalg.cond(solved.robot.jacobian(q)), rtol=1e-3)
    assert min(data["clearance"]) > 0
    assert data["worst"][0]["w"] <= min(data["w"]) + 3e-7  # as the page rounds times and w


@pytest.mark.parametrize("rows", ["pose", "translation", "rotation", "planar"])
def test_the_tool_is_as_fast_whichever_rows_w_is_of(rows: str) -> None:
    checker, home = checker_of("panda", "empty"), load("panda").home
    trajectory = time_path(np.array([home, home + 0.3]), checker)
    shown = ShownPath(trajectory.columns[0], [], motion=sample_motion(trajectory, checker))
    speed = motion_data(replace(checker.robot, jacobian_rows=rows), shown)["motion"]["tool_speed"]
    q = trajectory.at(np.linspace(0.0, trajectory.duration, SHOWN_STATES))
    step = trajectory.duration / (SHOWN_STATES - 1)
    numeric = np.linalg.norm(np.gradient(tool_positions(checker.robot, q), step, axis=0), axis=1)
    np.testing.assert_allclose(speed[1:-1], numeric[1:-1], atol=0.02)


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_ellipsoid_holds_the_velocities_that_unit_joint_velocities_reach(robot: str) -> None:
    """Against finite differences of the tool's place: the largest stretch in any direction is its support there."""
    arm, rng = load(robot), np.random.default_rng(0)
    q = random_q(arm, 3)
    step = 1e-6
    for row, (xx, yy, zz, xy, xz, yz) in zip(q, ellipsoids(arm, q), strict=True):
        root = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        ahead, behind = (tool_positions(arm, row + sign * step * np.eye(arm.dof)) for sign in (1, -1))
        numeric = ((ahead - behind) / (2 * step)).T
        directions = rng.normal(size=(20, 3))
        np.testing.assert_allclose(
            np.linalg.norm(directions @ numeric, axis=1), np.linalg.norm(directions @ root, axis=1), atol=1e-6
        )
        assert np.linalg.eigvalsh(root).min() >= -1e-9


def lowest(robot: Robot, path: np.ndarray) -> list[dict[str, Any]]:
    dense = dense_path(path)
    return find_worst_points(robot, dense, path_shares(dense)[0])


def test_worst_points_of_known_curves() -> None:
    """planar_2r: w = l1 l2 |sin q2|, so the minima are where the elbow is nearest to straight."""
    arm = load("planar_2r")
    there_and_back = np.array([[0.0, 1.5], [0.0, 0.2], [0.0, 1.0], [0.0, 0.4], [0.0, 1.5]])
    shares, _ = path_shares(there_and_back)
    first, second = lowest(arm, there_and_back)
    assert (first["share"], second["share"]) == pytest.approx((shares[1], shares[3]))
    flat = np.array([[0.0, 1.0], [1.0, 1.0]])
    assert len(lowest(arm, flat)) >= 1
    assert lowest(arm, np.array([[0.0, 1.0], [0.0, 0.5]]))[0]["share"] == 1.0
