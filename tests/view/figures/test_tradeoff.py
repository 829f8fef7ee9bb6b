"""Figures of a trade-off."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planner.problem.outcome import Outcome
from planner.problem.request import SweepRequest
from planner.tradeoff.result import Interval, Tradeoff
from planner.view import figures
from tests.view.figures.panels import lines, require_labels

NONE: Any = None


def interval(low: float, high: float, omega: float, distance: float) -> Interval:
    empty = np.zeros(0)
    measures = dict.fromkeys(("w_min", "w_mean", "joint_length", "workspace_length"), 0.0)
    return Interval(
        beta_min=low,
        beta_max=high,
        manipulability_cost=omega,
        distance_cost=distance,
        path_nodes=empty.astype(np.int64),
        path=empty,
        cost_to_go=NONE,
        **measures,
    )


def tradeoff(*intervals: Interval) -> Tradeoff:
    outcome = Outcome.SOLVED if intervals else Outcome.NO_PATH
    return Tradeoff(SweepRequest(), outcome, NONE, NONE, intervals=intervals)


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
