"""How good a path is at most: a cost that no path between the same ends falls below, on whatever roadmap."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats
from planner.cost.scale import manipulability_cost
from planner.kinematics.forward import tool_positions
from planner.problem.objective import Metric, Objective
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot


def cost_lower_bound(roadmap: Roadmap, robot: Robot, objective: Objective) -> float:
    """A lower bound on the cost, as the network of ``roadmap`` charges it, of every path from a start to a goal.

    Starts and goals are the roadmap's: of what is asked of the tool, other configurations may be nearer to each other.
    No path is shorter than the straight line between its ends, in joint space or (metric "workspace") from tool to
    tool. omega is nowhere below ``scale.zeta``: integrated over that length it costs so much at least. Charged at
    nodes, the goal's own omega is all that every path pays. The least of all pairs of a start and a goal counts.
    """
    starts, goals = roadmap.nodes[roadmap.starts], roadmap.nodes[roadmap.goals]
    distance = _straight(robot, starts, goals, objective.metric)
    distance /= roadmap.scale.joint_length if objective.metric == "joint" else roadmap.scale.tool_length
    moves = (robot.difference(starts[:, None], goals[None]) != 0).any(axis=2)
    if objective.charge == "edges":
        omega = roadmap.scale.zeta * distance
    else:
        name, w = objective.manipulability_cost, roadmap.manipulability[roadmap.goals]
        omega = np.broadcast_to(manipulability_cost(w, roadmap.scale, name), moves.shape)
    return float(np.where(moves, objective.total(omega, distance), 0.0).min())


def _straight(robot: Robot, starts: Floats, goals: Floats, metric: Metric) -> Floats:
    """(s, g) straight-line lengths, rad of joint motion or metres of the tool's."""
    if metric == "joint":
        return np.linalg.norm(robot.difference(starts[:, None], goals[None]), axis=2)
    here, there = (tool_positions(robot, q) for q in (starts, goals))
    return np.linalg.norm(here[:, None] - there[None], axis=2)
