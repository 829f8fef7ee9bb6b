"""Figures of a trade-off."""

from __future__ import annotations

from typing import Any

import numpy as np

from planner import figures
from planner.problem.outcome import Outcome
from planner.problem.request import SweepRequest
from planner.tradeoff.result import Interval, Tradeoff
from tests.figures.panels import data, require_labels

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
    figure = figures.pareto_front(tradeoff(*THREE))
    require_labels(figure)
    (axes,) = figure.axes
    assert np.array_equal(data(axes.get_lines()[0]).T, POINTS)
    assert [text.get_text() for text in axes.texts] == [
        "$\\beta$ 0 to 0.25",
        "$\\beta$ 0.25 to 0.5",
        "$\\beta$ 0.5 to 1",
    ]


def test_labels_of_near_paths_do_not_lie_on_each_other() -> None:
    near = [interval(k / 9, (k + 1) / 9, 1.0 + 0.01 * k, 5.0 - 0.01 * k) for k in range(8)]
    axes = figures.pareto_front(tradeoff(interval(0, 0, 0.5, 9.0), *near)).axes[0]
    heights = np.array([text.get_position()[1] for text in axes.texts])
    low, high = axes.get_ylim()
    assert np.diff(heights).max() < -0.05 * (high - low)
