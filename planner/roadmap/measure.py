"""What is measured on every edge of a roadmap, for the costs along it."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.kinematics.forward import tool_path_lengths
from planner.kinematics.manipulability import node_manipulability
from planner.models.robot import Robot
from planner.objective.integral import costs_along
from planner.objective.scale import CostScale, measure_scale


class EdgeMeasures(TypedDict):
    """Everything that a roadmap keeps of its edges except their proofs, by the names of its arrays."""

    joint_length: Floats
    tool_length: Floats
    edge_manipulability: Floats
    edge_cost: Floats


def measure_edges(robot: Robot, nodes: Floats, edges: Ints, scale: CostScale) -> EdgeMeasures:
    """What a roadmap whose costs are on ``scale`` keeps of ``edges`` (m, 2)."""
    motions = _motions(robot, nodes, edges)
    return _measures(robot, motions, _lengths(robot, *motions), scale)


def measure_anew(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, CostScale, EdgeMeasures]:
    """Manipulability (n,) of ``nodes``, the scale that these and ``edges`` (m, 2) set, and their measures on it."""
    w, motions = node_manipulability(robot, nodes), _motions(robot, nodes, edges)
    lengths = _lengths(robot, *motions)
    scale = measure_scale(w, *lengths)
    return w, scale, _measures(robot, motions, lengths, scale)


def edge_lengths(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, Floats]:
    """Joint motion (m,) rad and length of the tool's path (m,) metres of every edge."""
    return _lengths(robot, *_motions(robot, nodes, edges))


def _motions(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, Floats]:
    """Where edges begin and how far they go, (m, dof) each."""
    start = nodes[edges[:, 0]]
    return start, robot.difference(start, nodes[edges[:, 1]]).reshape(-1, robot.dof)


def _lengths(robot: Robot, start: Floats, delta: Floats) -> tuple[Floats, Floats]:
    return np.linalg.norm(delta, axis=1), tool_path_lengths(robot, start, delta)


def _measures(
    robot: Robot, motions: tuple[Floats, Floats], lengths: tuple[Floats, Floats], scale: CostScale
) -> EdgeMeasures:
    (joint, tool), (w, cost) = lengths, costs_along(robot, *motions, scale)
    return EdgeMeasures(joint_length=joint, tool_length=tool, edge_manipulability=w, edge_cost=cost)
