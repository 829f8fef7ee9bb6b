"""Short cuts: straight motions from starts to goals, and past waypoints of a roadmap's best paths, all proven."""

from __future__ import annotations

import itertools

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.polylines import cut, parts_of
from planner.base.products import length
from planner.base.progress import QUIET, Progress
from planner.native.graphs import cheapest_nodes
from planner.roadmap.best_paths import BETAS
from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.forest import Forest
from planner.roadmap.motion_cost import MotionCost
from planner.roadmap.motions import Motions
from planner.roadmap.roadmap import Roadmap
from planner.world.robot import Robot

_LEAST_GAIN = 1e-4  # relative
_PROVEN_PER_PATH = 60  # of the motions past waypoints, those that save most


def straight_paths(motions: Motions, starts: Floats, goals: Floats, longest: float) -> list[Floats]:
    """The proven ones of the straight motions from every row of ``starts`` (s, dof) to every row of ``goals`` (g, dof).

    Each is a path (k, dof) of pieces no longer than ``longest`` (rad).
    """
    robot = motions.robot
    found = []
    for a, b in itertools.product(starts, goals):
        delta = robot.difference(a, b)
        if delta.any() and motions.proven(a, delta):
            found.append(subdivided(robot, np.array([a, b]), longest))
    return found


def subdivided(robot: Robot, path: Floats, longest: float) -> Floats:
    """The path (k, dof) with no motion longer than ``longest`` (rad): a piece of a proven motion is proven."""
    delta = robot.difference(path[:-1], path[1:])
    parts = parts_of(np.array([length(motion) for motion in delta]), longest)
    rows = robot.normalise(cut(path, parts, delta))
    rows[np.cumsum([0, *parts])] = path
    return rows


def shortcuts(roadmap: Roadmap, prover: RecordingProver, longest: float, progress: Progress = QUIET) -> Forest:
    """Proven motions past waypoints of the best path from every start, for each of ``BETAS``, where they are cheaper.

    The cost is integrated along motions, see :class:`MotionCost`. In pieces no longer than ``longest`` (rad).
    """
    robot, forest = prover.robot, Forest(roadmap.nodes)
    for beta in BETAS:
        cost = MotionCost(robot, roadmap.scale, beta, longest=np.inf)
        for nodes in _best_paths(roadmap, cost.of_edges(roadmap)):
            if progress.stopped:
                return forest
            path = robot.unwound(roadmap.nodes[nodes])
            for i, j in _cheaper(prover, path, cost):
                ends = roadmap.nodes[[nodes[i], nodes[j]]]  # to the last bit
                forest.add_path(subdivided(robot, ends, longest))
    return forest


def _best_paths(roadmap: Roadmap, cost: Floats) -> list[Ints]:
    """The nodes (k,) of the cheapest path to a goal from every start that reaches one; edges have ``cost`` (m,)."""
    n, arcs = len(roadmap.nodes), np.concatenate([roadmap.edges, roadmap.edges[:, ::-1]])
    starts = dict.fromkeys(roadmap.starts.tolist())
    found = (cheapest_nodes(n, arcs, np.tile(cost, 2), np.array([start]), roadmap.goals) for start in starts)
    return [nodes for nodes in found if len(nodes)]


def _cheaper(prover: RecordingProver, path: Floats, cost: MotionCost) -> list[tuple[int, int]]:
    """Pairs of waypoints (i, j) of ``path`` (k, dof) that the cheapest way along it skips from one to the other."""
    k = len(path)
    i, j = (rows.astype(np.int64) for rows in np.triu_indices(k, 2))
    if not len(i):
        return []
    step = cost(path[:-1], path[1:])
    so_far = np.concatenate([[0.0], np.cumsum(step)])
    direct, around = cost(path[i], path[j]), so_far[j] - so_far[i]
    worth = np.flatnonzero(direct < (1.0 - _LEAST_GAIN) * around)
    worth = worth[np.argsort((direct - around)[worth], kind="stable")[:_PROVEN_PER_PATH]]
    free = prover.free(path[i[worth]], path[j[worth]] - path[i[worth]])
    proven = {(int(i[row]), int(j[row])): float(direct[row]) for row in worth[free]}
    return _cheapest_steps(step, proven)


def _cheapest_steps(step: Floats, skips: dict[tuple[int, int], float]) -> list[tuple[int, int]]:
    """The ``skips`` (i, j), with their costs, on the cheapest way along all of len(step) + 1 places."""
    into: dict[int, list[tuple[int, float]]] = {}
    for (i, j), price in skips.items():
        into.setdefault(j, []).append((i, price))
    best, come_from = [0.0], [0]
    for place, price in enumerate(step.tolist(), start=1):
        ways = [(best[place - 1] + price, place - 1), *((best[i] + p, i) for i, p in into.get(place, []))]
        least, previous = min(ways)
        best.append(least)
        come_from.append(previous)
    taken, place = [], len(step)
    while place:
        if come_from[place] < place - 1:
            taken.append((come_from[place], place))
        place = come_from[place]
    return taken
