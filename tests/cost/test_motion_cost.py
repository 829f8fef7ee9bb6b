"""What straight motions cost, against the network's own arcs and a fine integral."""

import numpy as np
import pytest

from planner.cost.motion_cost import MotionCost
from planner.cost.scale import COSTS, CostScale, length_cost, manipulability_cost, mean_manipulability_cost, w_along
from planner.kinematics.forward import tool_path_lengths
from planner.kinematics.manipulability import manipulability
from planner.problem.options import CostIntegration, Metric
from planner.problem.request import Objective
from planner.search.network import build_network
from tests.worlds import load, random_q, small_plan


@pytest.mark.parametrize("beta", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("cost_integration", ["nodes", "edges"])
@pytest.mark.parametrize("metric", ["joint", "workspace"])
def test_motions_cost_what_the_network_charges(beta: float, cost_integration: CostIntegration, metric: Metric) -> None:
    made = small_plan()
    roadmap = made.roadmap
    objective = Objective(beta, metric=metric, cost_integration=cost_integration)
    network = build_network(roadmap, objective)
    cost = MotionCost(made.robot, roadmap.scale, objective, np.inf)
    a, b = roadmap.nodes[network.tails], roadmap.nodes[network.indices]
    theirs = network.arcs(np.zeros(network.n_arcs))
    np.testing.assert_allclose(cost(a, b), theirs, rtol=1e-9)


@pytest.mark.parametrize("beta", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("metric", ["joint", "workspace"])
def test_pieces_cost_together_what_their_motion_costs(beta: float, metric: Metric) -> None:
    made = small_plan()
    cost = MotionCost(made.robot, made.roadmap.scale, Objective(beta, metric=metric), np.inf)
    a = made.roadmap.nodes[made.roadmap.edges[:, 0]]
    b = a + made.robot.difference(a, made.roadmap.nodes[made.roadmap.edges[:, 1]])
    shares = np.linspace(0.0, 1.0, 201)[:, None, None]
    places = a + shares * (b - a)
    fine, coarse = (sum(map(cost.for_pieces, at[:-1], at[1:])) for at in (places, places[::5]))
    np.testing.assert_allclose(fine, coarse, rtol=0.02)
    long = cost(a, b) > 2.0 * made.roadmap.scale.zeta
    np.testing.assert_allclose(cost.for_pieces(a, b)[long], cost(a, b)[long], rtol=1e-9)


@pytest.mark.parametrize(("beta", "floor", "longest"), [(0.0, 0.0, np.inf), (0.4, 0.03, 0.8), (1.0, 0.03, 0.8)])
@pytest.mark.parametrize("cost_integration", ["nodes", "edges"])
def test_edges_cost_what_their_motions_cost(
    beta: float, floor: float, longest: float, cost_integration: CostIntegration
) -> None:
    made = small_plan()
    roadmap = made.roadmap
    cost = MotionCost(
        made.robot, roadmap.scale, Objective(beta, floor=floor, cost_integration=cost_integration), longest
    )
    a, b = roadmap.nodes[roadmap.edges].swapaxes(0, 1)
    motions = cost(a, a + made.robot.difference(a, b))
    assert np.isfinite(motions).any()
    assert floor == 0 or np.isinf(motions).any()
    np.testing.assert_allclose(cost.charge_edges(roadmap), motions, rtol=1e-9)


@pytest.mark.parametrize("name", ["panda", "kinova", "planar_2r"])
@pytest.mark.parametrize("cost_integration", ["nodes", "edges"])
@pytest.mark.parametrize(("beta", "floor"), [(0.0, 0.0), (0.3, 0.0), (0.3, 0.02), (1.0, 0.02), (1.0, 0.0)])
@pytest.mark.parametrize("metric", ["joint", "workspace"])
def test_motions_cost_what_numpy_says(
    name: str, cost_integration: CostIntegration, beta: float, floor: float, metric: Metric
) -> None:
    robot, rng = load(name), np.random.default_rng(3)
    a = random_q(robot, 200, seed=4)
    b = a + rng.normal(size=a.shape) * rng.uniform(0.0, 2.0, 200)[:, None]
    b[0], longest = a[0], 2.5
    scale = CostScale(0.02, 0.2, 1.7, 0.9, 0.01)
    for kind in COSTS:
        objective = Objective(beta, kind, metric=metric, cost_integration=cost_integration, floor=floor)
        costs = MotionCost(robot, scale, objective, longest)(a, b)
        assert np.isfinite(costs).any()
        for start, end, cost in zip(a, b, costs.tolist(), strict=True):
            length = float(np.linalg.norm(end - start))
            w = next(w[0] for _, w in w_along(robot, start[None], (end - start)[None], np.array([length])))
            one = np.array([length])
            tool = tool_path_lengths(robot, start[None], (end - start)[None])
            distance = float(length_cost(scale, metric, one, tool)[0])
            mean = float(mean_manipulability_cost(w[None], scale, kind)[0]) * distance
            omega = float(manipulability_cost(w[-1:], scale, kind)[0]) if cost_integration == "nodes" else mean
            whole = (1.0 - beta) * omega + beta * distance
            turned = (np.abs(end - start) >= np.pi)[robot.continuous].any()
            barred = turned or (beta < 1.0 and length > longest) or (floor > 0 and w.min() < floor)
            assert cost == pytest.approx(np.inf if barred else whole, rel=1e-12)


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


@pytest.mark.parametrize("name", ["panda", "kinova"])
def test_what_is_to_be_short_costs_its_length(name: str) -> None:
    robot = load(name)
    a, b = random_q(robot, 40, seed=0), random_q(robot, 40, seed=1)
    b = a + robot.difference(a, b)
    np.testing.assert_allclose(MotionCost.from_length(robot)(a, b), np.linalg.norm(b - a, axis=1), rtol=1e-13)


def test_half_a_turn_of_a_free_joint_is_barred() -> None:
    """Its ends tell the motion the other way round as well, whatever the angles are counted on from."""
    robot = load("kinova")
    joint, scale = int(np.flatnonzero(robot.continuous)[0]), CostScale(0.02, 0.2, 1.7, 0.9, 0.01)
    by = np.zeros((4, robot.dof))
    by[:, joint] = [np.pi, -np.pi, np.pi - 1e-6, 1e-6 - np.pi]
    start = np.repeat(robot.home[None], 4, axis=0)
    for beta in (0.5, 1.0):
        cost = MotionCost(robot, scale, Objective(beta), np.inf)(start, start + by)
        assert np.isfinite(cost).tolist() == [False, False, True, True]
