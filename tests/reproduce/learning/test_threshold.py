"""The threshold between right and wrong paths."""

from __future__ import annotations

import numpy as np
import pytest

from planner.reproduce.learning.graphs import GridGraph, dijkstra_path, draw_grid
from planner.reproduce.learning.threshold import PRECISION, threshold


def grid(seed: int) -> GridGraph:
    return draw_grid(np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(4))
def test_the_threshold_parts_right_from_wrong(seed: int) -> None:
    graph = grid(seed)
    found = threshold(graph)

    def right(K: float) -> bool:
        return np.array_equal(dijkstra_path(graph.network, -np.log1p(-graph.d / K))[0], graph.shortest)

    assert found.longest < found.smallest <= found.bound
    assert all(map(right, np.geomspace(found.smallest * (1.0 + PRECISION), 2.0 * found.bound, 60)))
    if found.smallest > 1.001 * found.longest:
        assert not right(found.smallest * (1.0 - 1e-6))
    probes = np.geomspace(found.longest * 1.0001, found.smallest * 0.999, 25) if not found.holds_below else ()
    assert not any(right(K) for K in probes if found.longest < K)
