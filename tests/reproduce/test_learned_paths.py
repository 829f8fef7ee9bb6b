"""The figure of learned paths shows the weights and paths of its stages."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from planner.gabf import learning
from reproduce.figures import learned_paths

POSITION = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.5]])
# from node 0 to the source 2 over node 1, or over node 3, which is shorter
WBAR = {(0, 1): 0.5, (1, 2): 0.6, (0, 3): 0.9, (3, 2): 0.2}


def test_links_are_shaded_by_weight_and_both_paths_drawn() -> None:
    arcs = np.array(sorted(WBAR))
    network = learning.make_untrained_network(arcs[:, 0], arcs[:, 1], np.array([2]), 4)
    trained = replace(network, weight=np.array([WBAR[i, j] for i, j in arcs.tolist()]))
    stage = learning.planning_stage(trained, iteration=6)
    assert stage.path(0).tolist() == [0, 1, 2]
    figure = learned_paths({"rule": [stage, stage]}, POSITION, np.array([0, 3, 2]))
    axes: Any = figure.axes[0]
    (links,) = (c for c in axes.collections if type(c).__name__ == "LineCollection")
    assert links.get_array().tolist() == sorted(WBAR.values()), "dark ones on top, so last"
    drawn = [line.get_xydata().tolist() for line in axes.get_lines()]
    assert POSITION[[0, 1, 2]].tolist() in drawn
    assert POSITION[[0, 3, 2]].tolist() in drawn
    excess = 100.0 * (2.0 / (0.5 + np.hypot(1.0, 0.5)) - 1.0)
    assert axes.get_title() == f"rule, iteration 6\n{excess:.1f} % too long"
