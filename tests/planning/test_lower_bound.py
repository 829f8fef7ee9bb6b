"""No path costs less than the bound: against Dijkstra's answer on roadmaps, and where it is met exactly."""

from dataclasses import replace
from itertools import product
from typing import get_args

import numpy as np
import pytest

from planner import gabf
from planner.planning.quality import cost_lower_bound
from planner.problem.options import CostIntegration, Metric
from planner.problem.request import Objective
from planner.roadmap.roadmap import Roadmap
from planner.search.network import build_network
from tests.worlds import load, post_roadmap

ROBOT = load("planar_2r")


def least(roadmap: Roadmap, beta: float, metric: Metric, cost_integration: CostIntegration) -> float:
    network = build_network(roadmap, Objective(beta, "log", metric, cost_integration))
    return float(gabf.oracle(network)[roadmap.starts].min())


@pytest.mark.parametrize(("metric", "cost_integration"), [*product(get_args(Metric), get_args(CostIntegration))])
def test_no_roadmap_has_a_cheaper_path(metric: Metric, cost_integration: CostIntegration) -> None:
    rng = np.random.default_rng(0)
    for beta in (0.0, 0.3, 1.0):
        for _ in range(5):
            starts, goals = np.split(rng.choice(len(post_roadmap().nodes), 5, replace=False), [2])
            roadmap = replace(post_roadmap(), starts=starts, goals=goals)
            bound = cost_lower_bound(roadmap, ROBOT, Objective(beta, "log", metric, cost_integration))
            assert 0 < bound <= least(roadmap, beta, metric, cost_integration) + 1e-12


def test_by_length_alone_an_edge_meets_it() -> None:
    i, j = post_roadmap().edges[3]
    roadmap = replace(post_roadmap(), starts=np.array([i]), goals=np.array([j]))
    bound = cost_lower_bound(roadmap, ROBOT, Objective(1.0))
    assert bound == pytest.approx(least(roadmap, 1.0, "joint", "edges"), rel=1e-12)


def test_who_stands_at_the_goal_pays_nothing() -> None:
    roadmap = replace(post_roadmap(), starts=np.array([4]), goals=np.array([4, 9]))
    assert cost_lower_bound(roadmap, ROBOT, Objective(cost_integration="nodes")) == 0.0
