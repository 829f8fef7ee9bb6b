"""Figures of the learning simulations show the numbers that they were given."""

from __future__ import annotations

from typing import Any

import numpy as np

from planner.figures.learning import (
    CurvePanel,
    GraphPanel,
    execution_curves,
    learned_paths,
    scan_maps,
    share_curves,
    threshold_scatter,
)
from tests.figures.panels import data, lines

PANEL = GraphPanel(
    "before",
    np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    np.array([[0, 1], [1, 2], [2, 0]]),
    np.array([0.5, 0.9, 0.2]),
    np.array([0, 1, 2]),
    np.array([0, 2]),
)


def test_links_are_shaded_by_weight_and_both_paths_drawn() -> None:
    figure = learned_paths([[PANEL, PANEL]])
    axes: Any = figure.axes[0]
    (links,) = (c for c in axes.collections if type(c).__name__ == "LineCollection")
    assert links.get_array().tolist() == [0.2, 0.5, 0.9], "dark ones on top, so last"
    drawn = [line.get_xydata().tolist() for line in axes.get_lines()]
    assert PANEL.position[PANEL.path].tolist() in drawn
    assert PANEL.position[PANEL.shortest].tolist() in drawn


def test_shares_are_per_cent_from_before_the_first_iteration() -> None:
    (axes,) = share_curves({"Hebbian": [0.1, 0.5], "error-driven": [0.2, 1.0]}, graphs=3).axes
    shown = lines(axes)
    np.testing.assert_allclose(shown["error-driven"], [[0, 1], [20, 100]])
    assert "3 graphs" in axes.get_ylabel()


def test_the_threshold_stands_below_its_bound() -> None:
    gap, smallest, bound = np.array([0.1, 0.01]), np.array([2.0, 20.0]), np.array([5.0, 50.0])
    (axes,) = threshold_scatter(gap, smallest, bound, 1000.0).axes
    shown = [data(line)[1].tolist() for line in axes.get_lines()]
    assert bound.tolist() in shown
    assert smallest.tolist() in shown
    assert [1000.0, 1000.0] in shown


def test_maps_leave_out_what_was_not_tried() -> None:
    figure = scan_maps([0.1, 1.0], [0.5, 2.0], {"Hebbian": np.array([[0.25, np.nan], [1.0, 0.5]])}, graphs=4)
    texts = sorted(text.get_text() for text in figure.axes[0].texts)
    assert texts == ["100", "25", "50"]


def test_curves_are_means_over_roadmaps_and_windows() -> None:
    values = np.array([[4.0, 2.0, 2.0, 0.0], [0.0, 2.0, 0.0, 0.0]])
    panel = CurvePanel("regret", "regret (%)", {"optimistic": values}, window=2, band=True, level=1.0)
    figure = execution_curves([panel])
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("executions", "regret (%)")
    np.testing.assert_allclose(lines(axes)["optimistic"][1], [2.0, 0.5])
    assert len(axes.collections) == 1, "the band"
