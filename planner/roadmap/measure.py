"""Measures of nodes and edges: manipulability, lengths, and checks of nodes by the library."""

import logging
from collections.abc import Callable
from dataclasses import replace
from typing import TypedDict

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.cost.scale import CostScale, costs_along, measure_scale
from planner.kinematics.forward import tool_path_lengths
from planner.kinematics.manipulability import node_manipulability
from planner.roadmap.roadmap import LIBRARIES, Roadmap
from planner.robot.robot import Robot


class EdgeMeasures(TypedDict):
    """The arrays of a roadmap's edges except their proofs."""

    joint_length: Floats
    tool_length: Floats
    edge_manipulability: Floats
    edge_cost: Floats


def measure_edges(robot: Robot, nodes: Floats, edges: Ints, scale: CostScale) -> EdgeMeasures:
    """Return the measures of ``edges`` (m, 2) on the ``scale`` of a roadmap."""
    return _measure(robot, nodes, edges, lambda joint, tool: scale)[1]


def measure_roadmap(robot: Robot, nodes: Floats, edges: Ints) -> tuple[Floats, CostScale, EdgeMeasures]:
    """Return w (n,) of ``nodes``, the scale that these and ``edges`` (m, 2) set, and the edges' measures."""
    w = node_manipulability(robot, nodes)
    return w, *_measure(robot, nodes, edges, lambda joint, tool: measure_scale(w, joint, tool))


def _measure(
    robot: Robot, nodes: Floats, edges: Ints, scale_of: Callable[[Floats, Floats], CostScale]
) -> tuple[CostScale, EdgeMeasures]:
    """Return measures of edges on the scale for their joint lengths (m,) rad and tool lengths (m,) m."""
    start = nodes[edges[:, 0]]
    delta = robot.difference(start, nodes[edges[:, 1]]).reshape(-1, robot.dof)
    joint, tool = np.linalg.norm(delta, axis=1), tool_path_lengths(robot, start, delta)
    scale = scale_of(joint, tool)
    w, cost = costs_along(robot, start, delta, scale)
    return scale, EdgeMeasures(joint_length=joint, tool_length=tool, edge_manipulability=w, edge_cost=cost)


_log = logging.getLogger(__name__)


def check_nodes(roadmap: Roadmap, checker: CollisionChecker, first: int = 0) -> Roadmap:
    """Return the roadmap after the library of ``checker`` has checked all nodes from ``first`` on.

    One query per state that it has not checked yet. Refused nodes are removed with their edges, and the log reports
    them: they contradict a proof.
    """
    library, checked_by = LIBRARIES.index(checker.name), roadmap.checked_by.copy()
    open_ = first + np.flatnonzero(checked_by[first:] != library)
    if not len(open_):
        return roadmap
    refused = open_[_find_contacts(checker, roadmap.nodes[open_])]
    checked_by[open_] = library
    result = replace(roadmap, checked_by=checked_by)
    if not len(refused):
        return result
    free = np.ones(len(roadmap.nodes), dtype=bool)
    free[refused] = False
    return result.part(free, np.ones(len(roadmap.edges), dtype=bool))


def _find_contacts(checker: CollisionChecker, q: Floats) -> Ints:
    """Return the rows of (n, dof) that the library does not find free, and log the contacts."""
    rows, begin = [], 0
    while (first := checker.first_contact(q[begin:])) is not None:
        row, contact = begin + first[0], first[1]
        how = contact.how(checker.world.margin)
        _log.warning("node removed: by %s, %s %s there, against the proofs", checker.name, contact, how)
        rows, begin = [*rows, row], row + 1
    return np.array(rows, dtype=np.int64)
