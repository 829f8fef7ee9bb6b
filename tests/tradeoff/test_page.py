"""The page of a trade-off: its paths by interval, and a message for every ending."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from planner.problem.outcome import Outcome
from planner.tradeoff.page import of_tradeoff, sweep_page
from planner.tradeoff.sweep import Tradeoff
from tests.browser import page_data


def test_every_interval_has_a_path(swept: Tradeoff) -> None:
    shown = of_tradeoff(swept)
    assert [path.interval for path in shown] == [(item.beta_min, item.beta_max) for item in swept.intervals]
    for path, item in zip(shown, swept.intervals, strict=False):
        np.testing.assert_array_equal(path.path, item.path)
        assert path.costs == (item.manipulability_cost, item.distance_cost)


def test_the_page_opens_at_half_where_it_is_complete(swept: Tradeoff, tmp_path: Path) -> None:
    for tradeoff, beta in ((swept, 0.5), (replace(swept, complete=False, outcome=Outcome.INTERRUPTED), 0.0)):
        (tmp_path / "sweep.html").write_text(sweep_page(tradeoff))
        data = page_data(tmp_path / "sweep.html")
        assert data["beta"] == beta
        low, high = data["paths"][data["current"]]["interval"]
        assert low <= beta <= high
