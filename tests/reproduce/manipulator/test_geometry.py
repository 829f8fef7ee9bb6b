"""Geometry of tool paths."""

import numpy as np
import pytest

from planner.kinematics.forward import tool_positions
from reproduce.manipulator.case import shared_segments
from reproduce.manipulator.geometry import kinks, mean_distance, sampled_tool_path, turning
from tests.worlds import load, random_q


def test_a_sampled_tool_path_is_even_and_as_long_as_the_tool_travels() -> None:
    robot, path = load("iiwa14"), random_q(load("iiwa14"), 4)
    points = sampled_tool_path(robot, path, 0.01)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert points[[0, -1]] == pytest.approx(tool_positions(robot, path[[0, -1]]), abs=1e-12)
    assert steps.max() < 0.0101
    assert np.median(steps) == pytest.approx(0.01, rel=0.02)


def test_a_circle_turns_once_and_a_line_not_at_all() -> None:
    angle = np.linspace(0, 2 * np.pi, 400)
    circle = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    assert turning(circle) == pytest.approx(2 * np.pi, rel=0.01)
    assert turning(np.linspace([0, 0, 0], [1, 2, 3], 50)) == pytest.approx(0.0, abs=1e-6)
    assert turning(np.array([[0, 0, 0], [1, 0, 0], [0.5, 0, 0]])) == pytest.approx(np.pi)


def test_kinks_are_the_angles_between_the_tools_directions() -> None:
    robot, path = load("iiwa14"), random_q(load("iiwa14"), 5, seed=3)
    found, h = kinks(robot, path), 1e-6
    for k in range(1, 4):
        here = tool_positions(robot, path[k])[0]
        before = here - tool_positions(robot, path[k] - h * (path[k] - path[k - 1]))[0]
        after = tool_positions(robot, path[k] + h * (path[k + 1] - path[k]))[0] - here
        cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
        assert found[k - 1] == pytest.approx(np.arccos(cosine), abs=1e-4)
    assert len(kinks(robot, path[:2])) == 0
    straight = np.linspace(path[0], path[1], 4)
    assert kinks(robot, straight) == pytest.approx(0.0, abs=1e-6)


def test_distance_and_common_segments() -> None:
    line = np.linspace([0, 0, 0], [1, 0, 0], 11)
    assert mean_distance(line, line + np.array([0, 0.2, 0])) == pytest.approx(0.2)
    assert mean_distance(line, line[::-1]) == 0.0
    path = np.arange(10.0).reshape(5, 2)
    assert shared_segments(path, path[::-1]) == 1.0
    assert shared_segments(path, path[:3]) == 1.0
    assert shared_segments(path, np.vstack([path[:2], path[3:]])) == pytest.approx(2 / 3)
    assert shared_segments(path, path + 0.5) == 0.0
