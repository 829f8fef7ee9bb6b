"""What straight motions cost, against the network's own arcs."""

from __future__ import annotations

import numpy as np
import pytest

from planner.base.request import Charge, Metric
from planner.costs.network import build_network
from planner.roadmap.motion_cost import MotionCost
from tests.worlds import small_plan


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("charge", ["nodes", "edges"])
@pytest.mark.parametrize("metric", ["joint", "workspace"])
def test_motions_cost_what_the_network_charges(beta: float, charge: Charge, metric: Metric) -> None:
    made = small_plan()
    roadmap = made.roadmap
    network = build_network(roadmap, beta, metric=metric, charge=charge)
    cost = MotionCost(made.robot, roadmap.scale, beta, metric=metric, charge=charge, longest=np.inf)
    a, b = roadmap.nodes[network.tails], roadmap.nodes[network.indices]
    theirs = network.arcs(np.zeros(network.n_arcs))
    # the tool's path is summed over fewer points here
    np.testing.assert_allclose(cost(a, b), theirs, rtol=1e-9 if metric == "joint" else 0.04)
