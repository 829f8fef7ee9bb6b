"""What is measured on every edge of a roadmap, for the costs along it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypedDict

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.cost.scale import CostScale, costs_along, measure_scale
from planner.kinematics.forward import tool_path_lengths
from planner.kinematics.manipulability import node_manipulability
from planner.robot.robot import Robot


class EdgeMeasures(TypedDict):
    """Everything that a roadmap keeps of its edges except their proofs, by the names of its arrays."""

    joint_length: Floats
    tool_length: Floats
    edge_manipulability: Floats
    edge_cost: Floats


def measure_edges(robot: Robot, nodes: Floats, edges: Ints, scale: CostScale) -> EdgeMeasures:
    """What a roadmap whose costs are on ``scale`` keeps of ``edges`` (m, 2)."""
    return _measured(robot, nodes, edges, lambda joint, tool: scale)[1]


def measure_anew(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, CostScale, EdgeMeasures]:
    """Manipulability (n,) of ``nodes``, the scale that these and ``edges`` (m, 2) set, and their measures on it."""
    w = node_manipulability(robot, nodes)
    return w, *_measured(robot, nodes, edges, lambda joint, tool: measure_scale(w, joint, tool))


def _measured(
    robot: Robot, nodes: Floats, edges: Ints, scale_of: Callable[[Floats, Floats], CostScale]
) -> tuple[CostScale, EdgeMeasures]:
    """The measures of edges on the scale for their lengths (m,) in joint motion (rad) and of the tool's path (m)."""
    start = nodes[edges[:, 0]]
    delta = robot.difference(start, nodes[edges[:, 1]]).reshape(-1, robot.dof)
    joint, tool = np.linalg.norm(delta, axis=1), tool_path_lengths(robot, start, delta)
    scale = scale_of(joint, tool)
    w, cost = costs_along(robot, start, delta, scale)
    return scale, EdgeMeasures(joint_length=joint, tool_length=tool, edge_manipulability=w, edge_cost=cost)
