"""The paths for every beta are those that Dijkstra's algorithm finds at betas inside their intervals."""

from __future__ import annotations

import numpy as np
import pytest

from planner import gabf
from planner.base.progress import Progress
from planner.planning.result import Plan
from planner.search.network import at_beta
from planner.tradeoff.alternatives import with_alternatives


def test_each_interval_has_its_optimum_and_together_they_are_all_of_it(solved: Plan) -> None:
    assert solved.layered is not None
    layered = solved.layered
    shown = with_alternatives(solved).alternatives
    ends = [path.interval for path in shown if path.interval]
    assert (ends[0][0], ends[-1][1]) == (0.0, 1.0)
    assert [low for low, _ in ends[1:]] == pytest.approx([high for _, high in ends[:-1]])
    for path, (low, high) in zip(shown, ends, strict=True):
        beta = 0.5 * (low + high)
        x = gabf.oracle(at_beta(layered.network, beta))
        assert path.costs is not None
        omega, distance = path.costs
        assert (1 - beta) * omega + beta * distance == pytest.approx(x[layered.starts].min(), rel=1e-9)
        np.testing.assert_allclose(path.path[0], solved.path[0], atol=1e-12)


def test_a_stopped_search_shows_none(solved: Plan) -> None:
    assert with_alternatives(solved, Progress(stop=lambda: True)).alternatives == ()
