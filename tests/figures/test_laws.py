"""Figures of the laws: every curve with its data, labels with units, zero drawn at the floor of a log axis."""

from __future__ import annotations

from typing import Any

import numpy as np

from planner import gabf
from planner.figures.laws import exponent_summary, fixed_time_bounds, near_deadline, nine_node_graph, node_histories
from tests.figures.panels import data, lines, require_labels

T = np.linspace(0.0, 2.0, 5)
HISTORY = (T, np.array([3.0, 1.0, 0.1, 0.0, 0.0]), np.array([-4.0, -2.0, -1.0, 0.0, 0.0]))


def test_a_nodes_error_and_input_stand_beside_each_other() -> None:
    figure = node_histories([("h = 1", {"one": HISTORY, "two": HISTORY}), ("h = 2", {"one": HISTORY})], 3, 4.0)
    parts: Any = figure.subfigs
    assert len(parts) == 2
    errors, sizes, inputs = parts[0].axes
    shown = lines(errors)
    assert set(shown) == {"one", "two"}
    np.testing.assert_array_equal(shown["one"], [[*T, 4.0], [3.0, 1.0, 0.1, 0.0, 0.0, 0.0]])
    assert data(sizes.get_lines()[0])[1].min() == 1e-10, "zero has no place on a log axis"
    assert data(inputs.get_lines()[0])[1, 0] == -4.0
    assert "x_{3}" in errors.get_ylabel()
    assert "(km/s)" in inputs.get_ylabel()
    assert errors.get_xlim()[1] <= 4.0


def test_the_time_left_runs_out_to_the_right() -> None:
    figure = near_deadline({"rk45": (T, np.array([1.0, 0.5, 0.1, 0.01, 0.0]))}, 2.0)
    (axes,) = figure.axes
    require_labels(figure)
    left, error = lines(axes)["rk45"]
    np.testing.assert_allclose(left, 2.0 - T[:-1])
    assert error.tolist() == [1.0, 0.5, 0.1, 0.01]
    assert axes.xaxis_inverted()


def test_exponents_have_medians_with_their_range() -> None:
    grid = {(p, m): [(1.0, 10.0), (3.0, 30.0), (2.0, 20.0)] for p in ("1/3", "1/2") for m in ("3/1", "5/1")}
    figure = exponent_summary({"above": grid, "below": grid})
    assert len(figure.axes) == 4
    settling: Any = figure.axes[0]
    medians = [container.lines[0].get_ydata().tolist() for container in settling.containers]
    assert medians == [[2.0, 2.0], [2.0, 2.0]]
    assert [text.get_text() for text in settling.get_legend().get_texts()] == ["3/1", "5/1"]


def test_bounds_are_shown_with_what_was_measured() -> None:
    values = {"printed": [1.0, 2.0], "corrected": [3.0, 4.0], "sharp": [2.5, 3.5], "measured": [2.4, 3.4]}
    (axes,) = fixed_time_bounds(["1/2, 3/1", "1/3, 5/1"], values).axes
    shown = [data(line)[1].tolist() for line in axes.get_lines()]
    assert sorted(shown) == sorted(values.values())


def test_the_nine_nodes_show_every_arc_once_and_true_parents_thick() -> None:
    net = gabf.examples.nine_node()
    found = gabf.structure(net)
    (axes,) = nine_node_graph(net, found).axes
    widths = [patch.get_linewidth() for patch in axes.patches]
    assert len(widths) == net.n_arcs
    assert sum(width > 2 for width in widths) == len(found.true_arcs)
    texts = [text.get_text() for text in axes.texts]
    assert all(any(f"{k}\n$x^* = {found.x_star[k - 1]:g}$" == text for text in texts) for k in range(1, 10))
