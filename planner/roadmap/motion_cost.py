"""What straight motions cost, as the network of a roadmap charges them, before they are edges of one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.base.request import DEFAULT_COST, DEFAULT_METRIC, Charge, ManipulabilityCost, Metric
from planner.base.resolutions import W_STATES_PER_EDGE
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability_along
from planner.roadmap.roadmap import Roadmap
from planner.roadmap.scale import CostScale, manipulability_cost, mean_manipulability_cost
from planner.world.robot import Robot

LONGEST = 2.0  # rad: on longer motions W_STATES_PER_EDGE states do not tell the mean of omega
_SHARES = np.linspace(0.0, 1.0, W_STATES_PER_EDGE)


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
        distance = np.maximum(self._distance(a, delta, length), self.scale.zeta)
        far = (np.abs(delta[:, self.robot.continuous]) > np.pi).any(axis=1)
        if self.beta == 1.0 and self.floor <= 0:
            return np.where(far, np.inf, distance)
        w = manipulability_along(self.robot, a, delta, _SHARES)
        return np.where(far, np.inf, self._along(w, distance, length))

    def of_edges(self, roadmap: Roadmap) -> Floats:
        """(m,) costs of a roadmap's edges from their first node to their second, from what it keeps of them."""
        joint = self.metric == "joint"
        length = (
            roadmap.joint_length / self.scale.joint_length if joint else roadmap.tool_length / self.scale.tool_length
        )
        distance = np.maximum(length, self.scale.zeta)
        known = (self.scale, self.manipulability, self.charge) == (roadmap.scale, DEFAULT_COST, "edges")
        omega = roadmap.omega * distance if known and self.beta < 1.0 else None
        return self._along(roadmap.edge_manipulability, distance, roadmap.joint_length, omega)

    def _along(self, w: Floats, distance: Floats, length: Floats, omega: Floats | None = None) -> Floats:
        """(k,) costs of motions along which w (k, W_STATES_PER_EDGE) is known; infinite if too long or too singular.

        ``omega`` (k,): the part of manipulability, where it is known.
        """
        cost = distance
        if self.beta < 1.0:
            omega = self._omega(w, distance) if omega is None else omega
            cost = (1.0 - self.beta) * omega + self.beta * distance
            if np.isfinite(self.longest):
                cost = np.where(length > self.longest, np.inf, cost)
        return np.where(w.min(axis=1, initial=np.inf) < self.floor, np.inf, cost) if self.floor > 0 else cost

    def _omega(self, w: Floats, distance: Floats) -> Floats:
        if self.charge == "nodes":
            return manipulability_cost(w[:, -1], self.scale, self.manipulability)
        return mean_manipulability_cost(w, self.scale, self.manipulability) * distance

    def _distance(self, a: Floats, delta: Floats, length: Floats) -> Floats:
        if self.metric == "joint":
            return length / self.scale.joint_length
        states = a[:, None] + _SHARES[:, None] * delta[:, None]
        tool = tool_positions(self.robot, states.reshape(-1, self.robot.dof))
        steps = np.diff(tool.reshape(len(a), -1, 3), axis=1)
        return np.linalg.norm(steps, axis=2).sum(axis=1) / self.scale.tool_length
