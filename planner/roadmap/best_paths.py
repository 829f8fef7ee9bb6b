"""Refined paths: the roadmap's best paths, made better conditioned or shorter and added to the roadmap.

RRT fills the space without regard to cost, so few of its nodes lie where a good path would pass. Once the roadmap has
grown, its best path for each of a few betas is refined over proven motions. The refined waypoints become nodes of the
roadmap, and their motions edges. So the roadmap favours well-conditioned configurations; these nodes count towards its
size, so fewer are left for the rest of the space.
"""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import EXTRA_CLEARANCE
from planner.collision.edge_prover import EdgeProver
from planner.cost.motion_cost import MotionCost
from planner.cost.scale import measure_scale
from planner.kinematics.manipulability import manipulability
from planner.native.graphs import cheapest_nodes
from planner.problem.request import Objective
from planner.roadmap.forest import Forest
from planner.roadmap.refine import PathRefiner, cut
from planner.robot.robot import Robot

BETAS = (0.0, 0.25, 1.0)  # with a refined path: both extremes, and where much w is gained for little length
_TRIES = 4  # partial shortcuts in the one round of refinement per beta: a plan's own rounds go on from there
_PIECE = 1.0  # rad: longer motions of refined paths are cut, as other paths are to branch off from them
_DIP = 0.5  # a motion dips where w falls below this share of what it is at its ends
_DIP_SHARES = np.linspace(0.0, 1.0, 33)


def add_refined_paths(
    prover: EdgeProver,
    nodes: Floats,
    edges: Ints,
    starts: Ints,
    goals: Ints,
    budget: int,
    floor: float = 0.0,
    seed: int = 0,
    progress: Progress = QUIET,
) -> tuple[Floats, Ints]:
    """``nodes`` (n, dof) and proven ``edges`` (m, 2) with refined paths of ``BETAS``, at most ``budget`` nodes more.

    Nothing is added where starts and goals are not connected. With a ``floor`` (w) a path is refined only where it lies
    above the floor, and stays above it.
    """
    robot = prover.robot
    a, b = (nodes[ends] for ends in edges.T)
    scale = measure_scale(manipulability(robot, nodes), np.linalg.norm(robot.difference(a, b), axis=1), np.zeros(0))
    forest = Forest(nodes, edges)
    for beta in BETAS:
        cost = MotionCost(robot, scale, Objective(beta), longest=np.inf)
        path = best_path(nodes, edges, cost(a, a + robot.difference(a, b)), starts, goals)
        if path is None or progress.stopped:
            break
        above = np.flatnonzero(manipulability(robot, path) >= floor)
        if len(above) < 3:
            continue
        ends = path[[above[0], above[-1]]]
        refiner = PathRefiner(prover, cost.above(floor), EXTRA_CLEARANCE, seed, progress, _TRIES)
        refined = robot.unwound(path[above[0] : above[-1] + 1])
        if not np.isfinite(refiner.total(refined)):  # links may dip below the floor
            continue
        rows = robot.normalise(_with_dips(robot, cut(refiner.round(refined), _PIECE)))
        rows[[0, -1]] = ends  # these nodes exist already: the same to the last bit
        fresh = len({q.tobytes() for q in rows if q not in forest})
        if fresh <= budget:
            forest.add_path(rows)
            budget -= fresh
    return forest.nodes(), forest.edges()


def _with_dips(robot: Robot, path: Floats) -> Floats:
    """The path with a waypoint where w dips inside a motion, so that a cost charged at nodes sees the singularity."""
    a, delta = path[:-1], np.diff(path, axis=0)
    states = a[:, None] + _DIP_SHARES[:, None] * delta[:, None]
    w = manipulability(robot, states.reshape(-1, robot.dof)).reshape(len(a), -1)
    lowest = w.argmin(axis=1)
    dips = np.flatnonzero(w.min(axis=1) < _DIP * np.minimum(w[:, 0], w[:, -1]))
    return np.insert(path, dips + 1, states[dips, lowest[dips]], axis=0)


def best_path(nodes: Floats, edges: Ints, cost: Floats, starts: Ints, goals: Ints) -> Floats | None:
    """The configurations (k, dof) of the cheapest path from a start to a goal; None if there is none."""
    rows = cheapest_nodes(len(nodes), np.concatenate([edges, edges[:, ::-1]]), np.tile(cost, 2), starts, goals)
    return nodes[rows] if len(rows) else None
