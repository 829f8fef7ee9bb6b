"""Figures of a trade-off."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import planner
from planner import figures
from planner.problem.outcome import Outcome
from planner.problem.request import SweepRequest
from planner.tradeoff.result import Interval, Tradeoff
from tests.figures.panels import data, lines, require_labels

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
    checker: Any = SimpleNamespace(robot=planner.Robot.load("planar_2r"))
    return Tradeoff(SweepRequest(), outcome, checker, NONE, intervals=intervals)


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


def test_over_beta_the_least_cost_is_that_of_all_paths_at_every_beta() -> None:
    figure = figures.over_beta(tradeoff(*THREE), rows=["cost"])
    require_labels(figure)
    best = lines(figure.axes[0])["the best path"]
    betas = np.linspace(0, 1, 201)
    least = ((1 - betas[:, None]) * POINTS[:, 0] + betas[:, None] * POINTS[:, 1]).min(axis=1)
    assert np.interp(betas, *best) == pytest.approx(least, rel=1e-12)
    drawn = [data(line) for line in figure.axes[0].get_lines()[:3]]
    assert [line[:, 1].tolist() for line in drawn] == [[1.0, omega_d[1]] for omega_d in POINTS.tolist()]
