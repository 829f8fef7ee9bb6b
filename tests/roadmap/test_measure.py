"""What a roadmap keeps of its edges."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.resolutions import W_STATES_PER_EDGE
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.roadmap.measure import measure_edges
from tests.worlds import load, small_plan


def test_edge_manipulability_is_w_from_end_to_end() -> None:
    robot, rng = load("iiwa14"), np.random.default_rng(1)
    nodes = rng.uniform(robot.lower, robot.upper, (4, 7))
    edges = np.array([[0, 1], [2, 3]])
    w = measure_edges(robot, nodes, edges, small_plan().roadmap.scale)["edge_manipulability"]
    assert w.shape == (2, W_STATES_PER_EDGE)
    np.testing.assert_allclose(w[:, 0], manipulability(robot, nodes[[0, 2]]))
    np.testing.assert_allclose(w[:, -1], manipulability(robot, nodes[[1, 3]]), rtol=1e-9)


@pytest.mark.parametrize("name", ["planar_2r", "iiwa14", "kinova"])
def test_edge_lengths_against_a_plain_sum(name):
    robot, rng = load(name), np.random.default_rng(0)
    nodes = rng.uniform(robot.lower, robot.upper, size=(8, robot.dof))
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 7], [0, 7], [4, 4], [5, 6]])
    scale = small_plan().roadmap.scale
    measured = measure_edges(robot, nodes, edges, scale)
    joint, tool = measured["joint_length"], measured["tool_length"]
    for (i, j), ours, way in zip(edges, joint, tool, strict=True):
        delta = robot.difference(nodes[i], nodes[j])
        assert ours == pytest.approx(np.linalg.norm(delta))
        fine = tool_positions(robot, nodes[i] + np.linspace(0, 1, 2001)[:, None] * delta)
        assert way == pytest.approx(np.linalg.norm(np.diff(fine, axis=0), axis=1).sum(), rel=2e-3, abs=1e-12)
    empty = measure_edges(robot, nodes, np.zeros((0, 2), dtype=int), scale)
    assert {name: len(np.asarray(values)) for name, values in empty.items()} == dict.fromkeys(measured, 0)
