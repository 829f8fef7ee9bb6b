"""What straight motions cost, as the network of a roadmap charges them, before they are edges of one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from planner.base.arrays import Floats
from planner.base.resolutions import W_STATES_PER_EDGE
from planner.kinematics.forward import tool_path_lengths
from planner.models.robot import Robot
from planner.objective.integral import w_along
from planner.objective.scale import CostScale, cost_number, length_cost, manipulability_cost, mean_manipulability_cost
from planner.problem.objective import Objective

LONGEST = 2.0  # rad: longer motions take no part in refinement


class MeasuredEdges(Protocol):
    """What is kept of edges (m,): lengths in rad and metres, w along them, and each of the ``COSTS`` on ``scale``."""

    @property
    def scale(self) -> CostScale: ...
    @property
    def joint_length(self) -> Floats: ...
    @property
    def tool_length(self) -> Floats: ...
    @property
    def edge_manipulability(self) -> Floats: ...
    @property
    def edge_cost(self) -> Floats: ...


@dataclass(frozen=True, eq=False)
class MotionCost:
    """What straight motions cost under an :class:`Objective`, as ``planning.network.build_network`` charges.

    The length is divided by the longest edge of the roadmap that ``scale`` was measured on; omega is integrated along
    the motion and multiplied by that, or with ``charge`` "nodes" that of the state it leads to. Infinite for motions
    with a state below the floor, where a continuous joint turns by more than half a turn, and unless beta is 1 for
    those longer than ``longest``. ``states``: in how many, at least, w is looked at along each.
    """

    robot: Robot
    scale: CostScale
    objective: Objective
    longest: float = LONGEST  # rad
    states: int = W_STATES_PER_EDGE

    def above(self, floor: float) -> MotionCost:
        """The same with another floor under w."""
        return replace(self, objective=replace(self.objective, floor=floor))

    def __call__(self, a: Floats, b: Floats) -> Floats:
        """(k,) costs from configurations ``a`` (k, dof) to ``b`` (k, dof), angles unwound."""
        delta = b - a
        length = np.linalg.norm(delta, axis=1)
        metric = self.objective.metric
        tool = tool_path_lengths(self.robot, a, delta) if metric == "workspace" else length
        cost = length_cost(self.scale, metric, length, tool)
        if self.objective.beta < 1.0 or self.objective.floor > 0:
            for rows, w in w_along(self.robot, a, delta, length, self.states):
                cost[rows] = self._traded_off(w, cost[rows], length[rows])
        return np.where((np.abs(delta[:, self.robot.continuous]) > np.pi).any(axis=1), np.inf, cost)

    def of_edges(self, edges: MeasuredEdges) -> Floats:
        """(m,) costs of a roadmap's edges from their first node to their second, from what it keeps of them.

        Their scale is this one.
        """
        assert self.scale == edges.scale
        distance = length_cost(self.scale, self.objective.metric, edges.joint_length, edges.tool_length)
        mean = edges.edge_cost[:, cost_number(self.objective.manipulability_cost)]
        return self._traded_off(edges.edge_manipulability, distance, edges.joint_length, mean)

    def _traded_off(self, w: Floats, distance: Floats, length: Floats, mean: Floats | None = None) -> Floats:
        """(k,) costs of motions along which w (k, states) is known; infinite if too long or too singular.

        ``mean`` (k,): of omega along them, where it is known.
        """
        cost, objective = distance, self.objective
        if objective.beta < 1.0:
            cost = objective.total(self._omega(w, distance, mean), distance)
            if np.isfinite(self.longest):
                cost = np.where(length > self.longest, np.inf, cost)
        if objective.floor > 0:
            return np.where(w.min(axis=1, initial=np.inf) < objective.floor, np.inf, cost)
        return cost

    def _omega(self, w: Floats, distance: Floats, mean: Floats | None) -> Floats:
        name = self.objective.manipulability_cost
        if self.objective.charge == "nodes":
            return manipulability_cost(w[:, -1], self.scale, name)
        return (mean_manipulability_cost(w, self.scale, name) if mean is None else mean) * distance
