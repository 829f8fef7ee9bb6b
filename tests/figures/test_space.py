"""Configuration space: where it is blocked, where it is singular, and what is drawn over that."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from planner import figures, gabf
from planner.figures.space import collision_grid, determinant_grid
from planner.search.network import build_network
from tests import worlds
from tests.coal_judge import CoalWorld
from tests.figures.panels import data, lines, require_labels


@pytest.fixture(scope="module")
def space() -> tuple[Figure, np.ndarray, np.ndarray]:
    """The configuration space around the post with its cost-to-go and a path."""
    roadmap = worlds.post_roadmap()
    network = build_network(roadmap, 0.5)
    field = gabf.solve(network)
    x = field.x.copy()
    x[7] = np.inf  # as a node that reaches no goal
    path = roadmap.nodes[gabf.extract_path(network, field, int(roadmap.starts[0]))]
    return figures.configuration_space(worlds.make_post(), roadmap, x, path, resolution=31), x, path


def test_the_configuration_space_shows_roadmap_cost_and_path(space: tuple[Figure, np.ndarray, np.ndarray]) -> None:
    figure, x, path = space
    require_labels(figure)
    axes, bar = figure.axes
    roadmap = worlds.post_roadmap()
    dots: Any = next(c for c in axes.collections if type(c).__name__ == "PathCollection")
    assert np.array_equal(np.ma.getdata(dots.get_array()), x[np.isfinite(x)])
    assert np.array_equal(np.ma.getdata(dots.get_offsets()), roadmap.nodes[np.isfinite(x)])
    assert bar.get_ylabel() == "cost-to-go $x$ (no unit)"
    assert np.array_equal(lines(axes)["path"].T, path)
    edges: Any = next(c for c in axes.collections if type(c).__name__ == "LineCollection")
    assert len(edges.get_segments()) == len(roadmap.edges)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("joint_1 (rad)", "joint_2 (rad)")
    grey = [line for line in axes.get_lines() if data(line).shape[1] == 1 and to_hex(line.get_color()) == "#999999"]
    assert len(grey) == 1


def test_the_blocked_region_and_the_singular_line_are_where_they_are() -> None:
    checker, robot = worlds.make_post(), worlds.load("planar_2r")
    first, second = np.linspace(-1.0, 1.0, 9), np.linspace(-2.9, 2.9, 9)
    coal = CoalWorld(checker.world)
    truth = [[coal.distances(np.array([p, q])).min() <= 0 for q in second] for p in first]
    assert 0 < np.sum(truth) < 81
    assert np.array_equal(collision_grid(checker, first, second), truth)
    assert determinant_grid(robot, first, second) == pytest.approx(np.tile(0.2 * np.sin(second), (9, 1)), abs=1e-12)
