"""What is measured on every edge of a roadmap, for the costs along it."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.resolutions import W_STATES_PER_EDGE
from planner.kinematics.forward import tool_path_lengths
from planner.kinematics.manipulability import manipulability_along, node_manipulability
from planner.objective.integral import mean_costs_along
from planner.objective.scale import CostScale, measure_scale
from planner.world.robot import Robot


class EdgeMeasures(TypedDict):
    """Everything that a roadmap keeps of its edges except their proofs, by the names of its arrays."""

    joint_length: Floats
    tool_length: Floats
    edge_manipulability: Floats
    edge_cost: Floats


def measure_edges(robot: Robot, nodes: Floats, edges: Ints, scale: CostScale) -> EdgeMeasures:
    """What a roadmap whose costs are on ``scale`` keeps of ``edges`` (m, 2)."""
    return _measures(robot, nodes, edges, scale, edge_lengths(robot, nodes, edges))


def measure_anew(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, CostScale, EdgeMeasures]:
    """Manipulability (n,) of ``nodes``, the scale that these and ``edges`` (m, 2) set, and their measures on it."""
    w, lengths = node_manipulability(robot, nodes), edge_lengths(robot, nodes, edges)
    scale = measure_scale(w, *lengths)
    return w, scale, _measures(robot, nodes, edges, scale, lengths)


def _measures(
    robot: Robot, nodes: Floats, edges: Ints, scale: CostScale, lengths: tuple[Floats, Floats]
) -> EdgeMeasures:
    joint, tool = lengths
    return EdgeMeasures(
        joint_length=joint,
        tool_length=tool,
        edge_manipulability=edge_manipulability(robot, nodes, edges),
        edge_cost=edge_costs(robot, nodes, edges, scale),
    )


def edge_lengths(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, Floats]:
    """Joint motion (m,) rad and length of the tool's path (m,) metres of every edge."""
    start, delta = _motions(robot, nodes, edges)
    return np.linalg.norm(delta, axis=1), tool_path_lengths(robot, start, delta)


def edge_costs(robot: Robot, nodes: Floats, edges: Ints, scale: CostScale) -> Floats:
    """The mean (m, 3) of each of the ``COSTS`` along every edge."""
    return mean_costs_along(robot, *_motions(robot, nodes, edges), scale)


def edge_manipulability(robot: Robot, nodes: Floats, edges: Ints) -> Floats:
    """w (m, W_STATES_PER_EDGE) at evenly spaced states of every edge, from its first node to its second."""
    shares = np.linspace(0.0, 1.0, W_STATES_PER_EDGE)
    return manipulability_along(robot, *_motions(robot, nodes, edges), shares)


def _motions(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, Floats]:
    """Where edges begin and how far they go, (m, dof) each."""
    start = nodes[edges[:, 0]]
    return start, robot.difference(start, nodes[edges[:, 1]]).reshape(-1, robot.dof)
