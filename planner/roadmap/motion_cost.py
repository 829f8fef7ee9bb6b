"""What straight motions cost, as the network of a roadmap charges them, before they are edges of one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.base.request import DEFAULT_COST, DEFAULT_METRIC, Charge, ManipulabilityCost, Metric
from planner.roadmap.integral import w_along
from planner.roadmap.measure import tool_lengths
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.scale import CostScale, cost_number, manipulability_cost, mean_manipulability_cost
from planner.world.robot import Robot

LONGEST = 2.0  # rad: longer motions take no part in refinement


@dataclass(frozen=True, eq=False)
class MotionCost:
    """The cost of straight motions under the kernels of :func:`planner.costs.network.build_network`.

    (1 - beta) omega + beta d: d is the length over the longest edge of the roadmap that ``scale`` was measured on,
    omega integrated along the motion and multiplied by d, or with ``charge`` "nodes" that of the state it leads to.
    Infinite for motions with a state below manipulability ``floor``, where a continuous joint turns by more than half a
    turn, and unless beta is 1 for those longer than ``longest``.
    """

    robot: Robot
    scale: CostScale
    beta: float
    floor: float = 0.0
    manipulability: ManipulabilityCost = DEFAULT_COST
    metric: Metric = DEFAULT_METRIC
    charge: Charge = "edges"
    longest: float = LONGEST  # rad

    def __call__(self, a: Floats, b: Floats) -> Floats:
        """(k,) costs from configurations ``a`` (k, dof) to ``b`` (k, dof), angles unwound."""
        delta = b - a
        length = np.linalg.norm(delta, axis=1)
        cost = self._distance(length, tool_lengths(self.robot, a, delta) if self.metric == "workspace" else length)
        if self.beta < 1.0 or self.floor > 0:
            for rows, w in w_along(self.robot, a, delta):
                cost[rows] = self._traded_off(w, cost[rows], length[rows])
        return np.where((np.abs(delta[:, self.robot.continuous]) > np.pi).any(axis=1), np.inf, cost)

    def of_edges(self, roadmap: Roadmap) -> Floats:
        """(m,) costs of a roadmap's edges from their first node to their second, from what it keeps of them.

        ``roadmap`` is the one whose scale this is, or that grew from it.
        """
        assert self.scale == roadmap.scale
        distance = self._distance(roadmap.joint_length, roadmap.tool_length)
        mean = roadmap.edge_cost[:, cost_number(self.manipulability)]
        return self._traded_off(roadmap.edge_manipulability, distance, roadmap.joint_length, mean)

    def _traded_off(self, w: Floats, distance: Floats, length: Floats, mean: Floats | None = None) -> Floats:
        """(k,) costs of motions along which w (k, states) is known; infinite if too long or too singular.

        ``mean`` (k,): of omega along them, where it is known.
        """
        cost = distance
        if self.beta < 1.0:
            cost = (1.0 - self.beta) * self._omega(w, distance, mean) + self.beta * distance
            if np.isfinite(self.longest):
                cost = np.where(length > self.longest, np.inf, cost)
        return np.where(w.min(axis=1, initial=np.inf) < self.floor, np.inf, cost) if self.floor > 0 else cost

    def _omega(self, w: Floats, distance: Floats, mean: Floats | None) -> Floats:
        if self.charge == "nodes":
            return manipulability_cost(w[:, -1], self.scale, self.manipulability)
        return (mean_manipulability_cost(w, self.scale, self.manipulability) if mean is None else mean) * distance

    def _distance(self, joint: Floats, tool: Floats) -> Floats:
        """(k,) of motions of so much joint motion (k,) in rad and tool path (k,) in metres; the metric's one counts."""
        length = joint / self.scale.joint_length if self.metric == "joint" else tool / self.scale.tool_length
        return np.maximum(length, self.scale.zeta)
