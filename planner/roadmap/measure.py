"""Measures of nodes and edges: manipulability and lengths for the costs, and checks of nodes by the library."""

import logging
from collections.abc import Callable
from dataclasses import replace
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.cost.scale import CostScale, costs_along, measure_scale
from planner.kinematics.forward import tool_path_lengths
from planner.kinematics.manipulability import node_manipulability
from planner.roadmap.roadmap import LIBRARIES, Roadmap
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


def measure_roadmap(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, CostScale, EdgeMeasures]:
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


_log = logging.getLogger(__name__)


def unchecked(count: int) -> NDArray[np.int8]:
    """``checked_by`` of nodes that no library has looked at."""
    return np.zeros(count, dtype=np.int8)


def check_nodes(roadmap: Roadmap, checker: CollisionChecker, first: int = 0) -> Roadmap:
    """The roadmap after the library of ``checker`` has looked at all nodes from ``first`` on that it had not.

    It is one query a state. What it refuses is left out with its edges, and the log says so: it contradicts a proof.
    """
    library, checked_by = LIBRARIES.index(checker.name), roadmap.checked_by.copy()
    open_ = first + np.flatnonzero(checked_by[first:] != library)
    if not len(open_):
        return roadmap
    refused = open_[_refused(checker, roadmap.nodes[open_])]
    checked_by[open_] = library
    looked = replace(roadmap, checked_by=checked_by)
    if not len(refused):
        return looked
    kept = np.ones(len(roadmap.nodes), dtype=bool)
    kept[refused] = False
    return looked.part(kept, np.ones(len(roadmap.edges), dtype=bool))


def _refused(checker: CollisionChecker, q: Floats) -> Ints:
    """The rows of configurations (n, dof) that the library does not find free; the log names what touches."""
    rows, begin = [], 0
    while (first := checker.first_contact(q[begin:])) is not None:
        row, contact = begin + first[0], first[1]
        how = contact.how(checker.world.margin)
        _log.warning("node left out: %s says that %s %s there, against the proofs", checker.name, contact, how)
        rows, begin = [*rows, row], row + 1
    return np.array(rows, dtype=np.int64)
