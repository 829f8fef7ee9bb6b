"""Costs of executing a roadmap's edges, against quadrature along the edge with Pinocchio's own Jacobian."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import trapezoid

from planner import build_network
from planner.base.errors import OptionError
from planner.learning.roadmap_costs import SlowZone, edge_of_arc, execution_costs, greatest_costs, least_costs
from planner.objective.scale import manipulability_cost
from planner.roadmap.roadmap import Roadmap
from tests.worlds import load

IIWA = "iiwa14"
BETA = 0.3


def quadrature(roadmap: Roadmap, row: int, zone: SlowZone | None, samples: int = 1201) -> float:
    """The integral along one edge by the trapezoidal rule on a grid of its own."""
    robot = load(IIWA)
    a, b = roadmap.nodes[roadmap.edges[row]]
    data = robot.model.createData()
    rates = []
    for s in np.linspace(0.0, 1.0, samples):
        q = a + s * (b - a)
        frame = pin.computeFrameJacobian(robot.model, data, q, robot.tool_id, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        w = np.sqrt(np.linalg.eigvalsh(frame @ frame.T).clip(0.0).prod())
        pin.updateFramePlacements(robot.model, data)
        rate = (1.0 - BETA) * manipulability_cost(np.array([w]), roadmap.scale)[0] + BETA
        inside = zone is not None and np.linalg.norm(data.oMf[robot.tool_id].translation - zone.centre) <= zone.radius
        rates.append(rate * zone.factor if zone is not None and inside else rate)
    length = float(np.linalg.norm(b - a)) / roadmap.scale.joint_length
    return float(trapezoid(rates, dx=1.0 / (samples - 1))) * length


def middle_of(roadmap: Roadmap, row: int) -> np.ndarray:
    robot = load(IIWA)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, roadmap.nodes[roadmap.edges[row]].mean(axis=0))
    return data.oMf[robot.tool_id].translation.copy()


def test_an_edge_costs_its_integral(roadmap: Roadmap) -> None:
    costs = execution_costs(load(IIWA), roadmap, BETA)
    long = np.argsort(roadmap.joint_length)[-40::10]
    for row in long:
        assert costs[row] == pytest.approx(quadrature(roadmap, int(row), None), rel=2e-3)


def test_a_slow_zone_counts_where_the_tool_is_inside(roadmap: Roadmap) -> None:
    row = int(np.argmax(roadmap.joint_length))
    zone = SlowZone(middle_of(roadmap, row), radius=0.15, factor=5.0)
    plain, slow = (execution_costs(load(IIWA), roadmap, BETA, zones) for zones in ((), (zone,)))
    assert slow[row] == pytest.approx(quadrature(roadmap, row, zone), rel=2e-2)
    assert plain[row] * 1.05 < slow[row] < plain[row] * 5.0
    assert (slow >= plain).all()
    everywhere = execution_costs(load(IIWA), roadmap, BETA, [SlowZone(np.zeros(3), 10.0, 5.0)])
    assert everywhere == pytest.approx(5.0 * plain, rel=1e-12)


def test_costs_lie_between_what_is_known_of_them(roadmap: Roadmap) -> None:
    zones = [SlowZone(np.array([0.5, 0.0, 0.5]), 0.5, 3.0), SlowZone(np.array([0.5, 0.0, 0.7]), 0.5, 2.0)]
    for beta in (0.0, 0.4, 1.0):
        costs = execution_costs(load(IIWA), roadmap, beta, zones)
        assert (least_costs(roadmap, beta) <= costs * (1.0 + 1e-12)).all()
        assert (costs <= greatest_costs(roadmap, zones) * (1.0 + 1e-12)).all()


def test_every_arc_finds_its_edge(roadmap: Roadmap) -> None:
    network = build_network(roadmap)
    edge = edge_of_arc(roadmap, network)
    ends = np.sort(np.column_stack([network.tails, network.indices]), axis=1)
    assert (roadmap.edges[edge] == ends).all()
    assert (np.bincount(edge) == 2).all()


@pytest.mark.parametrize(("radius", "factor"), [(0.0, 2.0), (-1.0, 2.0), (0.1, 0.5), (np.nan, 2.0)])
def test_a_zone_that_makes_no_sense_is_refused(radius: float, factor: float) -> None:
    with pytest.raises(OptionError, match="slow zone"):
        SlowZone(np.zeros(3), radius, factor)


def test_beta_is_a_share(roadmap: Roadmap) -> None:
    with pytest.raises(OptionError, match="beta"):
        execution_costs(load(IIWA), roadmap, 1.5)
