"""Figures of the simulations show the numbers that they are given."""

from typing import Any

import numpy as np
import pytest

from planner import gabf
from reproduce.example import nine_node
from reproduce.figures import beta_costs, exponent_summary, nine_node_graph
from tests.figures.panels import data, lines, require_labels


def test_exponents_have_medians_with_their_range() -> None:
    grid = {(p, m): [(1.0, 10.0), (3.0, 30.0), (2.0, 20.0)] for p in ("1/3", "1/2") for m in ("3/1", "5/1")}
    figure = exponent_summary({"above": grid, "below": grid})
    assert len(figure.axes) == 4
    settling: Any = figure.axes[0]
    medians = [container.lines[0].get_ydata().tolist() for container in settling.containers]
    assert medians == [[2.0, 2.0], [2.0, 2.0]]
    assert [text.get_text() for text in settling.get_legend().get_texts()] == ["3/1", "5/1"]


def test_the_nine_nodes_show_every_arc_once_and_true_parents_thick() -> None:
    net = nine_node()
    found = gabf.structure(net)
    (axes,) = nine_node_graph(net, found).axes
    widths = [patch.get_linewidth() for patch in axes.patches]
    assert len(widths) == net.n_arcs
    assert sum(width > 2 for width in widths) == len(found.true_arcs)
    texts = [text.get_text() for text in axes.texts]
    assert all(any(f"{k}\n$x^* = {found.x_star[k - 1]:g}$" == text for text in texts) for k in range(1, 10))


def test_costs_against_beta_are_medians_with_every_roadmap_behind() -> None:
    omega, distance = np.array([[1.0, 2, 4], [3, 4, 8], [2, 9, 10]]), np.array([[6.0, 5, 4], [8, 7, 4], [9, 9, 3]])
    rrt, printed = (np.array([7.0, 5, 6]), np.array([1.0, 2, 3])), (np.array([0.1, 1, 1]), np.array([3.0, 2, 2]))
    figure = beta_costs((0.0, 0.5, 1.0), (omega, distance), {"RRT": rrt}, printed)
    require_labels(figure)
    left, middle, right = figure.axes
    assert lines(left)["GABF, median"][1].tolist() == [2, 4, 8]
    assert lines(middle)["GABF, median"][1].tolist() == [8, 7, 4]
    assert lines(left)["RRT, median"][1].tolist() == [6, 6]
    grey = [line for line in middle.get_lines() if line.get_color() == "0.7"]
    assert [data(line)[1].tolist() for line in grey] == distance.tolist()
    assert lines(right)["$\\Omega$, paper"][1].tolist() == [0.1, 1, 1]
    assert lines(right)["$D$, ours (median)"][1] == pytest.approx([2.0, 1.75, 1.0])
