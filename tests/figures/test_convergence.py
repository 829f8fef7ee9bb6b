"""Convergence of the dynamics."""

from __future__ import annotations

import numpy as np
import pytest

from planner import figures, gabf
from reproduce.example import nine_node
from tests.figures.panels import data, lines, require_labels


@pytest.fixture(scope="module")
def laws() -> dict[str, gabf.CostToGo]:
    """Two laws on the nine-node example, with their trajectories."""
    network = nine_node()
    chosen = {"nominal": gabf.Nominal(), "singularity-free": gabf.SingularityFree(T=2.0)}
    return {name: gabf.solve(network, law=law, save_every=1) for name, law in chosen.items()}


def test_convergence_shows_the_trajectory_with_its_deadline(laws: dict[str, gabf.CostToGo]) -> None:
    nodes = np.array([2, 5])
    figure = figures.convergence(laws, nodes)
    require_labels(figure)
    nominal, free = figure.axes
    course = laws["nominal"].history
    assert course is not None
    assert len(nominal.get_lines()) == 3  # two nodes, settled; this law has no T_p
    assert np.array_equal(data(nominal.get_lines()[0])[1], course.x[:, 2])
    shown = lines(free)
    assert shown["$T_p$"][0].tolist() == [2.0, 2.0]
    assert shown["every node settled"][0][0] == laws["singularity-free"].settling_time
    assert data(free.get_lines()[1])[0, -1] == 2.0  # at rest until T_p
    assert data(free.get_lines()[1])[1, -1] == laws["singularity-free"].x[5]


def test_error_decay_is_the_distance_from_the_optimum(laws: dict[str, gabf.CostToGo]) -> None:
    figure = figures.error_decay(laws)
    require_labels(figure)
    (axes,) = figure.axes
    shown = lines(axes)
    assert set(shown) == {"nominal", "singularity-free", "$T_p = 2$ s"}
    course = laws["nominal"].history
    assert course is not None
    assert np.array_equal(shown["nominal"][0], course.t)
    error = np.abs(course.x - laws["singularity-free"].x).max(axis=1)  # the other law's answer, no oracle's
    assert shown["nominal"][1] == pytest.approx(np.maximum(error, 1e-10), rel=1e-6)
    assert axes.get_xlim() == (0.0, 3.0)
