"""What is measured on every edge of a roadmap, for the costs along it."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.resolutions import TOOL_ALONG_EDGE, W_STATES_PER_EDGE
from planner.kinematics.forward import tool_path_lengths
from planner.kinematics.manipulability import manipulability
from planner.world.robot import Robot


def measure_edges(robot: Robot, nodes: Floats, edges: Ints) -> dict[str, Floats]:
    """Everything that a roadmap keeps of its edges except their proofs, by the names of its arrays."""
    joint, tool = edge_lengths(robot, nodes, edges)
    return {
        "joint_length": joint,
        "tool_length": tool,
        "edge_manipulability": edge_manipulability(robot, nodes, edges),
    }


def edge_lengths(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, Floats]:
    """Joint motion (m,) rad and length of the tool's path (m,) metres of every edge."""
    delta = robot.difference(nodes[edges[:, 0]], nodes[edges[:, 1]]).reshape(-1, robot.dof)
    joint = np.linalg.norm(delta, axis=1)
    pieces = np.maximum(1, np.ceil(np.abs(delta).sum(axis=1) / TOOL_ALONG_EDGE)).astype(np.int64)
    return joint, tool_path_lengths(robot, nodes[edges[:, 0]], delta, pieces)


def edge_manipulability(robot: Robot, nodes: Floats, edges: Ints) -> Floats:
    """w (m, W_STATES_PER_EDGE) at evenly spaced states of every edge, from its first node to its second."""
    a = nodes[edges[:, 0]]
    delta = robot.difference(a, nodes[edges[:, 1]]).reshape(-1, 1, robot.dof)
    states = a[:, None] + np.linspace(0.0, 1.0, W_STATES_PER_EDGE)[:, None] * delta
    return manipulability(robot, states.reshape(-1, robot.dof)).reshape(-1, W_STATES_PER_EDGE)
