"""Figures of a trade-off."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planner.base.errors import OptionError
from planner.figures import figure as figures
from planner.problem.outcome import Outcome
from planner.problem.request import SweepRequest
from planner.tradeoff.sweep import Interval, Tradeoff
from tests.figures.panels import data, lines, require_labels

NONE: Any = None


def interval(low: float, high: float, omega: float, distance: float) -> Interval:
    empty = np.zeros(0)
    return Interval(low, high, empty.astype(np.int64), empty, omega, distance, 0.0, 0.0, 0.0, 0.0, NONE)


def tradeoff(*intervals: Interval) -> Tradeoff:
    outcome = Outcome.SOLVED if intervals else Outcome.NO_PATH
    return Tradeoff(SweepRequest(), outcome, NONE, NONE, NONE, NONE, intervals=intervals)


# lines meet at beta = 0.25 and 0.5; (2.5, 7.5) lies above all three, so that no beta reaches it
THREE = (interval(0.0, 0.25, 1.0, 10.0), interval(0.25, 0.5, 2.0, 7.0), interval(0.5, 1.0, 5.0, 4.0))


POINTS = np.array([[1.0, 10.0], [2.0, 7.0], [5.0, 4.0]])


def test_the_front_shows_each_path_with_its_interval() -> None:
    figure = figures.tradeoff_front(tradeoff(*THREE))
    require_labels(figure)
    (axes,) = figure.axes
    shown = lines(axes)
    assert np.array_equal(shown["optimal for some $\\beta$"].T, POINTS)
    assert [text.get_text() for text in axes.texts] == [
        "$\\beta$ 0 to 0.25",
        "$\\beta$ 0.25 to 0.5",
        "$\\beta$ 0.5 to 1",
    ]


def test_the_envelope_is_the_least_cost() -> None:
    figure = figures.cost_envelope(tradeoff(*THREE))
    require_labels(figure)
    shown = lines(figure.axes[0])
    beta = np.linspace(0, 1, 101)
    least = np.min([(1 - beta) * i.manipulability_cost + beta * i.distance_cost for i in THREE], axis=0)
    assert np.interp(beta, *shown["least cost"]) == pytest.approx(least, abs=1e-12)
    assert len(shown) == 4
    assert np.array_equal(shown["path 2"], [[0, 1], [2.0, 7.0]])


@pytest.mark.parametrize("draw", [figures.tradeoff_front, figures.cost_envelope])
def test_a_trade_off_without_a_path_cannot_be_drawn(draw: Any) -> None:
    with pytest.raises(OptionError, match="no path to draw"):
        draw(tradeoff())


def test_costs_against_beta_are_medians_with_every_roadmap_behind() -> None:
    omega, distance = np.array([[1.0, 2, 4], [3, 4, 8], [2, 9, 10]]), np.array([[6.0, 5, 4], [8, 7, 4], [9, 9, 3]])
    rrt, printed = (np.array([7.0, 5, 6]), np.array([1.0, 2, 3])), (np.array([0.1, 1, 1]), np.array([3.0, 2, 2]))
    figure = figures.beta_costs((0.0, 0.5, 1.0), (omega, distance), {"RRT": rrt}, printed)
    require_labels(figure)
    left, middle, right = figure.axes
    assert lines(left)["GABF, median"][1].tolist() == [2, 4, 8]
    assert lines(middle)["GABF, median"][1].tolist() == [8, 7, 4]
    assert lines(left)["RRT, median"][1].tolist() == [6, 6]
    grey = [line for line in middle.get_lines() if line.get_color() == "0.7"]
    assert [data(line)[1].tolist() for line in grey] == distance.tolist()
    assert lines(right)["$\\Omega$, paper"][1].tolist() == [0.1, 1, 1]
    assert lines(right)["$D$, ours (median)"][1] == pytest.approx([2.0, 1.75, 1.0])
