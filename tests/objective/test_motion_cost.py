"""What straight motions cost, against the network's own arcs and a fine integral."""

from __future__ import annotations

import numpy as np
import pytest

from planner.kinematics.manipulability import manipulability
from planner.objective.motion_cost import MotionCost
from planner.objective.scale import manipulability_cost
from planner.planning.network import build_network
from planner.problem.objective import Objective
from planner.problem.request import Charge, Metric
from tests.worlds import small_plan


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("charge", ["nodes", "edges"])
@pytest.mark.parametrize("metric", ["joint", "workspace"])
def test_motions_cost_what_the_network_charges(beta: float, charge: Charge, metric: Metric) -> None:
    made = small_plan()
    roadmap = made.roadmap
    objective = Objective(beta, metric=metric, charge=charge)
    network = build_network(roadmap, objective)
    cost = MotionCost(made.robot, roadmap.scale, objective, np.inf)
    a, b = roadmap.nodes[network.tails], roadmap.nodes[network.indices]
    theirs = network.arcs(np.zeros(network.n_arcs))
    np.testing.assert_allclose(cost(a, b), theirs, rtol=1e-9)


@pytest.mark.parametrize(("beta", "floor", "longest"), [(0.0, 0.0, np.inf), (0.4, 0.03, 0.8), (1.0, 0.03, 0.8)])
@pytest.mark.parametrize("charge", ["nodes", "edges"])
def test_edges_cost_what_their_motions_cost(beta: float, floor: float, longest: float, charge: Charge) -> None:
    made = small_plan()
    roadmap = made.roadmap
    cost = MotionCost(made.robot, roadmap.scale, Objective(beta, floor=floor, charge=charge), longest)
    a, b = roadmap.nodes[roadmap.edges].swapaxes(0, 1)
    motions = cost(a, a + made.robot.difference(a, b))
    assert np.isfinite(motions).any()
    assert floor == 0 or np.isinf(motions).any()
    np.testing.assert_allclose(cost.of_edges(roadmap), motions, rtol=1e-9)


@pytest.mark.parametrize("length", [0.5, 1.5, 3.0])
def test_motion_cost_is_the_integral(length: float) -> None:
    """Of long motions as well: nine states were up to 18 % off on motions of 3 rad."""
    made, rng = small_plan(), np.random.default_rng(0)
    towards = rng.normal(size=(60, 7))
    a = rng.uniform(made.robot.lower, made.robot.upper, (60, 7))
    b = a + length * towards / np.linalg.norm(towards, axis=1)[:, None]
    scale = made.roadmap.scale
    off = []
    for p, q, value in zip(a, b, MotionCost(made.robot, scale, Objective(0.3), np.inf)(a, b), strict=True):
        fine = p + np.linspace(0, 1, 2001)[:, None] * (q - p)
        omega = manipulability_cost(manipulability(made.robot, fine), scale)
        exact = length / scale.joint_length * (0.7 * np.trapezoid(omega, dx=1 / 2000) + 0.3)
        off.append(abs(value / exact - 1.0))
    assert np.mean(off) < 0.002
    assert max(off) < 0.02
