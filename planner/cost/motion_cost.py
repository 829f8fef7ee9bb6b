"""Costs of straight motions, as the network of a roadmap charges its edges."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Protocol

import numpy as np

from planner.base.arrays import Floats
from planner.base.resolutions import TOOL_ALONG_EDGE, W_IN_COST, W_STATES_PER_EDGE
from planner.cost.scale import CostScale, cost_number, length_cost, manipulability_cost
from planner.kinematics.forward import Chain
from planner.kinematics.manipulability import evaluate_measure, tools_and_rows
from planner.native.compiled import Charge
from planner.problem.request import Objective
from planner.robot.robot import Robot

LONGEST = 2.0  # rad: refinement ignores longer motions


class MeasuredEdges(Protocol):
    """Edges (m,) with lengths in rad and m, w along them, and the mean of each of ``COSTS`` on ``scale``."""

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
    """The cost of straight motions under an :class:`Objective`, as ``search.network.build_network``.

    The length is divided by the longest edge of the roadmap that ``scale`` was measured on; omega is integrated along
    the motion and multiplied by that length, or with ``charge`` "nodes" it is that of the end. Infinite for motions
    with a state below the floor, where a continuous joint turns by half a turn or more, and unless beta is 1 for those
    longer than ``longest``. ``states``: the least number of states at which w is evaluated along each.
    """

    robot: Robot
    scale: CostScale
    objective: Objective
    longest: float = LONGEST  # rad
    states: int = W_STATES_PER_EDGE

    @staticmethod
    def from_length(robot: Robot) -> MotionCost:
        """Return the cost of motions that should be short: the length of the joint motion (rad)."""
        unit = CostScale(w_low=1.0, w_high=2.0, joint_length=1.0, tool_length=1.0, zeta=0.0)
        return MotionCost(robot, unit, Objective(1.0), longest=np.inf)

    def above(self, floor: float) -> MotionCost:
        """Return the cost with another floor under w."""
        return replace(self, objective=replace(self.objective, floor=floor))

    @property
    def for_pieces(self) -> MotionCost:
        """The cost without the least length of an edge: that of a motion is the sum over its parts.

        The least length is zeta, and omega is zeta + (1 - zeta) times its value for zeta 0: beta absorbs the first
        term.
        """
        beta, zeta = self.objective.beta, self.scale.zeta
        whole = replace(self.objective, beta=beta + (1.0 - beta) * zeta)
        return replace(self, scale=replace(self.scale, zeta=0.0), objective=whole)

    def __call__(self, a: Floats, b: Floats) -> Floats:
        """Return (k,) costs from configurations ``a`` (k, dof) to ``b`` (k, dof), angles unwound."""
        return self.charge.costs(a, b)

    @cached_property
    def charge(self) -> Charge:
        """The same cost for the compiled library."""
        scale, objective = self.scale, self.objective
        by_joints = objective.metric == "joint"
        unit, chord = (scale.joint_length, 0.0) if by_joints else (scale.tool_length, TOOL_ALONG_EDGE)
        numbers = (scale.w_low, scale.w_high, scale.zeta, unit, objective.beta, objective.floor)
        return Charge(
            Chain.from_arm(self.robot).native,
            numbers=(*numbers, self.longest, W_IN_COST, chord),
            kind=cost_number(objective.manipulability_cost),
            at_end=objective.cost_integration == "nodes",
            fewest=self.states,
            wraps=self.robot.continuous,
            tools=tools_and_rows(self.robot),
            measure=None if self.robot.measure == "yoshikawa" else partial(evaluate_measure, self.robot),
        )

    def charge_edges(self, edges: MeasuredEdges) -> Floats:
        """Return (m,) costs of a roadmap's edges of this scale, from their first node to their second."""
        assert self.scale == edges.scale
        objective, w = self.objective, edges.edge_manipulability
        cost = distance = length_cost(self.scale, objective.metric, edges.joint_length, edges.tool_length)
        if objective.beta < 1.0:
            name = objective.manipulability_cost
            if objective.cost_integration == "nodes":
                omega = manipulability_cost(w[:, -1], self.scale, name)
            else:
                omega = edges.edge_cost[:, cost_number(name)] * distance
            cost = np.where(edges.joint_length > self.longest, np.inf, objective.total(omega, distance))
        return np.where(w.min(axis=1, initial=np.inf) < objective.floor, np.inf, cost)
