"""What executing the edges of a roadmap costs, which its planner is not told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner import gabf
from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import OptionError
from planner.base.polylines import parts_of
from planner.base.resolutions import COST_ALONG_EDGE
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability
from planner.models.robot import Robot
from planner.objective.scale import manipulability_cost
from planner.planning.network import distance_cost
from planner.problem.request import require_share
from planner.roadmap.roadmap import Roadmap


@dataclass(frozen=True, eq=False)
class SlowZone:
    """A ball of ``radius`` m around ``centre`` (3,) m in which motion costs ``factor`` times as much."""

    centre: Floats
    radius: float
    factor: float

    def __post_init__(self) -> None:
        if not (self.radius > 0.0 and self.factor >= 1.0):
            raise OptionError(
                f"a slow zone needs a positive radius and a factor of at least 1, not {self.radius} and {self.factor}."
            )

    def holds(self, positions: Floats) -> Bools:
        """(n,) which positions (n, 3) lie inside."""
        return np.linalg.norm(positions - self.centre, axis=1) <= self.radius


def execution_costs(robot: Robot, roadmap: Roadmap, beta: float, zones: Sequence[SlowZone] = ()) -> Floats:
    """(m,) the integral of ((1 - beta) omega(q) + beta) factor(q) dq along every edge, in units of the longest edge.

    What :class:`planner.gabf.EdgeIntegral` trades off, read along the whole edge every ``COST_ALONG_EDGE`` rad of joint
    motion (midpoint rule), times the factor of each slow zone that the tool is in.
    """
    require_share(beta)
    start = roadmap.nodes[roadmap.edges[:, 0]]
    delta = robot.difference(start, roadmap.nodes[roadmap.edges[:, 1]])
    pieces = parts_of(roadmap.joint_length, COST_ALONG_EDGE)
    row, first = np.repeat(np.arange(len(pieces)), pieces), np.cumsum(pieces) - pieces
    share = (np.arange(len(row)) - first[row] + 0.5) / pieces[row]
    q = start[row] + share[:, None] * delta[row]
    rate = (1.0 - beta) * manipulability_cost(manipulability(robot, q), roadmap.scale) + beta
    position = tool_positions(robot, q)
    for zone in zones:
        rate *= np.where(zone.holds(position), zone.factor, 1.0)
    mean = np.add.reduceat(rate, first) / pieces if len(pieces) else np.zeros(0)
    return mean * distance_cost(roadmap)


def least_costs(roadmap: Roadmap, beta: float) -> Floats:
    """(m,) what every edge costs at least: as if manipulability were best all along, and no zone slow."""
    return (beta + (1.0 - beta) * roadmap.scale.zeta) * distance_cost(roadmap)


def greatest_costs(roadmap: Roadmap, zones: Sequence[SlowZone] = ()) -> Floats:
    """(m,) what every edge costs at most: singular all along, and inside every zone."""
    return float(np.prod([zone.factor for zone in zones])) * distance_cost(roadmap)


def edge_of_arc(roadmap: Roadmap, network: gabf.Network) -> Ints:
    """(n_arcs,) the roadmap's edge that each arc of a network built on it stands for."""
    low, high = np.minimum(network.tails, network.indices), np.maximum(network.tails, network.indices)
    n = len(roadmap.nodes)
    return np.searchsorted(roadmap.edges[:, 0] * n + roadmap.edges[:, 1], low * n + high)
