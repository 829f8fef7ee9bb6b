"""Training runs."""

from __future__ import annotations

import numpy as np

from planner import learning
from planner.reproduce.learning.graphs import draw_grid
from planner.reproduce.learning.study import ERROR_DRIVEN


def test_the_same_seed_gives_the_same_courses() -> None:
    graph, again = (draw_grid(np.random.default_rng([4, 0, 7])) for _ in range(2))
    runs = [learning.learn(g.network, ERROR_DRIVEN, g.d, 2)[-1] for g in (graph, again)]
    assert runs[0].wbar.tolist() == runs[1].wbar.tolist()
    assert runs[0].field.x.tolist() == runs[1].field.x.tolist()
