"""Profiles along paths."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from planner.kinematics.manipulability import manipulability
from planner.planning.result import Plan
from planner.trajectory.measure import dense_path, path_clearance
from planner.view import figures
from tests.view.figures.panels import data, lines, require_labels


def test_profiles_show_w_and_clearance_along_each_path(solved: Plan) -> None:
    checker, robot = solved.checker, solved.robot
    half = solved.path[: len(solved.path) // 2 + 1]
    figure = figures.path_profiles(checker, {"whole": solved.path, "half": half})
    require_labels(figure)
    upper, lower = figure.axes
    shown = lines(upper)
    assert set(shown) == {"whole", "half"}
    q = dense_path(solved.path)
    assert np.array_equal(shown["whole"][1], manipulability(robot, q))
    length = sum(np.linalg.norm(b - a) for a, b in itertools.pairwise(solved.path))
    assert shown["whole"][0][[0, -1]] == pytest.approx([0.0, length])
    below = lower.get_lines()
    assert len(below) == 2
    assert np.array_equal(data(below[1])[1], path_clearance(checker, half)[1])
    assert "(m³)" in upper.get_ylabel()


def test_certified_clearance_is_drawn_against_what_was_measured() -> None:
    figure = figures.clearance_bounds(np.array([0.01, 0.02]), np.array([0.015, 0.05]))
    require_labels(figure)
    shown = lines(figure.axes[0])
    assert shown["an edge"].T.tolist() == [[0.015, 0.01], [0.05, 0.02]]
    assert np.array_equal(*shown["equal"])
