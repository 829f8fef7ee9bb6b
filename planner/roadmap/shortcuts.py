"""Additions to a grown roadmap: refined best paths, straight motions between ends and past waypoints."""

import itertools
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from planner.base.arrays import Floats, Ints, combine_costs, cumulative_sums, cut, frozen, length, parts_of
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import EXTRA_CLEARANCE
from planner.collision.edge_prover import EdgeProver
from planner.collision.path_moves import cheapest_chain
from planner.cost.motion_cost import MotionCost
from planner.cost.scale import measure_scale
from planner.kinematics.manipulability import manipulability
from planner.native.graphs import cheapest_nodes
from planner.problem.request import Objective
from planner.roadmap.edges import MotionChecker, RecordingProver
from planner.roadmap.forest import Forest
from planner.roadmap.refine import PathRefiner, split_evenly
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot

BETAS = (0.0, 0.25, 1.0)  # of refined paths: both extremes, and a beta with much w for little length
_TRIES = 4  # partial shortcuts in the one round of refinement per beta, which a plan's own rounds continue
_LONGEST = 1.0  # rad: longer motions of refined paths are split, so that other paths can branch off
_DIP = 0.5  # a motion dips where w falls below this share of w at its ends
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
    """Return ``nodes`` (n, dof) and proven ``edges`` (m, 2) with refined paths of ``BETAS`` added.

    They add at most ``budget`` nodes, none where starts and goals are not connected. With a ``floor`` (w) the section
    of a path above the floor is refined, and stays above it.
    """
    robot = prover.robot
    a, b = (nodes[ends] for ends in edges.T)
    scale = measure_scale(manipulability(robot, nodes), np.linalg.norm(robot.difference(a, b), axis=1), np.zeros(0))
    forest = Forest(nodes, edges)
    for beta in BETAS:
        cost = MotionCost(robot, scale, Objective(beta), longest=np.inf)
        path = find_best_path(nodes, edges, cost(a, a + robot.difference(a, b)), starts, goals)
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
        rows = robot.normalise(_insert_dips(robot, split_evenly(refiner.round(refined), _LONGEST)))
        rows[[0, -1]] = ends  # the exact nodes
        fresh = len({q.tobytes() for q in rows if q not in forest})
        if fresh <= budget:
            forest.add_path(rows)
            budget -= fresh
    return forest.nodes(), forest.edges()


def _insert_dips(robot: Robot, path: Floats) -> Floats:
    """Return the path with a waypoint where w dips, so that a cost charged at nodes sees the singularity."""
    a, delta = path[:-1], np.diff(path, axis=0)
    states = a[:, None] + _DIP_SHARES[:, None] * delta[:, None]
    w = manipulability(robot, states.reshape(-1, robot.dof)).reshape(len(a), -1)
    lowest = w.argmin(axis=1)
    dips = np.flatnonzero(w.min(axis=1) < _DIP * np.minimum(w[:, 0], w[:, -1]))
    return np.insert(path, dips + 1, states[dips, lowest[dips]], axis=0)


def find_best_path(nodes: Floats, edges: Ints, cost: Floats, starts: Ints, goals: Ints) -> Floats | None:
    """Return the configurations (k, dof) of the cheapest path from a start to a goal; None without one."""
    rows = cheapest_nodes(len(nodes), np.concatenate([edges, edges[:, ::-1]]), np.tile(cost, 2), starts, goals)
    return nodes[rows] if len(rows) else None


_LEAST_GAIN = 1e-4  # relative
_MOST_PER_PATH = 60  # motions past waypoints, those that save most


def prove_straight_paths(motions: MotionChecker, starts: Floats, goals: Floats, longest: float) -> list[Floats]:
    """Return the proven straight motions from every row of ``starts`` to every row of ``goals``.

    Each is a path (k, dof) of motions no longer than ``longest`` (rad).
    """
    robot = motions.robot
    paths = []
    for a, b in itertools.product(starts, goals):
        delta = robot.difference(a, b)
        if delta.any() and motions.is_proven(a, delta):
            paths.append(split_motions(motions.prover, np.array([a, b]), longest))
    return paths


def split_motions(prover: EdgeProver, path: Floats, longest: float) -> Floats:
    """Return a path (k, dof) of proven motions, split where they are longer than ``longest`` (rad).

    The parts have the certificates of the motions.
    """
    rows, parts = subdivide(prover.robot, path, longest)
    prover.note_pieces(path, rows, parts)
    return rows


def subdivide(robot: Robot, path: Floats, longest: float) -> tuple[Floats, Ints]:
    """Return the path with no motion over ``longest`` (rad), and the number of parts (m,) of each."""
    delta = robot.difference(path[:-1], path[1:])
    parts = count_parts(robot, delta, longest)
    rows = robot.normalise(cut(path, parts, delta))
    rows[cumulative_sums(parts)] = path
    return rows, parts


def count_parts(robot: Robot, delta: Floats, longest: float) -> Ints:
    """Return the number of parts (m,) of motions (m, dof) of at most ``longest``, each below half a turn."""
    parts = parts_of(np.array([length(motion) for motion in delta]), longest)
    return np.where(robot.is_below_half_turn(delta), parts, np.maximum(parts, 2))


@dataclass(frozen=True, eq=False)
class DraftRoadmap:
    """A roadmap and planned additions: nodes (k, dof) that follow its own, and proven edges (j, 2).

    ``starts`` and ``goals`` are node numbers.
    """

    roadmap: Roadmap
    added_nodes: Floats
    added_edges: Ints
    starts: Ints
    goals: Ints

    @cached_property
    def nodes(self) -> Floats:
        """(n, dof) all nodes."""
        return np.concatenate([self.roadmap.nodes, self.added_nodes])

    @cached_property
    def arcs(self) -> Ints:
        """(2 m, 2) the roadmap's and the added edges, then all of them reversed."""
        edges = np.concatenate([self.roadmap.edges, self.added_edges])
        return np.concatenate([edges, edges[:, ::-1]])

    def costs(self, cost: MotionCost) -> Floats:
        """Return (m,) the costs of the edges."""
        a, b = self.nodes[self.added_edges.T]
        return np.concatenate([cost.charge_edges(self.roadmap), cost(a, a + cost.robot.difference(a, b))])


def prove_shortcuts(
    linked: DraftRoadmap, prover: RecordingProver, longest: float, progress: Progress = QUIET
) -> Forest:
    """Return proven motions past waypoints of the best path from every start, per beta of ``BETAS``.

    They are cheaper than the path, with costs integrated along motions, see :class:`MotionCost`, and split at
    ``longest`` (rad).
    """
    robot, pairs = prover.robot, dict[tuple[int, int], None]()
    ends = [MotionCost(robot, linked.roadmap.scale, Objective(beta), longest=np.inf) for beta in (0.0, 1.0)]
    edges = [linked.costs(cost) for cost in ends]
    between: dict[bytes, list[Floats]] = {}  # betas often have one best path
    for beta in BETAS:
        for nodes in _best_paths(linked, _trade_off(beta, *edges)):
            if progress.stopped:
                break
            path, key = robot.unwound(linked.nodes[nodes]), nodes.tobytes()
            if key not in between:
                i, j = _pairs(len(path))
                between[key] = [cost(path[i], path[j]) for cost in ends]
            for i, j in _find_shortcuts(prover, path, _trade_off(beta, *between[key])):
                pairs[int(nodes[i]), int(nodes[j])] = None
    forest = Forest(linked.nodes)
    for pair in pairs:
        forest.add_path(split_motions(prover, linked.nodes[list(pair)], longest))
    return forest


def _trade_off(beta: float, omega: Floats, distance: Floats) -> Floats:
    """Return costs at ``beta`` from those at 0 and at 1; where one is infinite, so is the other."""
    if beta in (0.0, 1.0):
        return distance if beta else omega
    return combine_costs(beta, omega, distance)


@lru_cache
def _pairs(count: int) -> tuple[Ints, Ints]:
    """Return the smaller and the larger of every two of ``count`` numbers."""
    i, j = np.triu_indices(count, 1)
    return frozen(i, np.int64), frozen(j, np.int64)


def _best_paths(linked: DraftRoadmap, cost: Floats) -> list[Ints]:
    """Return the nodes (k,) of the cheapest path to a goal from every start that reaches one.

    Edges have ``cost`` (m,).
    """
    n, arcs, both, goals = len(linked.nodes), linked.arcs, np.tile(cost, 2), linked.goals
    starts = dict.fromkeys(linked.starts.tolist())
    ways = (cheapest_nodes(n, arcs, both, np.array([start]), goals) for start in starts)
    return [nodes for nodes in ways if len(nodes)]


def _find_shortcuts(prover: RecordingProver, path: Floats, direct: Floats) -> list[tuple[int, int]]:
    """Return proven pairs (i, j) of waypoints of ``path`` that the cheapest chain connects directly.

    ``direct`` are the costs of the motions between all pairs of waypoints, in the order of :func:`_pairs`.
    """
    i, j = _pairs(len(path))
    along = j == i + 1
    passed = cumulative_sums(direct[along])
    around = passed[j] - passed[i]
    worth = np.flatnonzero(direct < (1.0 - _LEAST_GAIN) * around)
    worth = worth[np.argsort((direct - around)[worth], kind="stable")[:_MOST_PER_PATH]]
    price = np.full((len(path), len(path)), np.inf)
    for rows in (np.flatnonzero(along), worth):
        price[i[rows], j[rows]] = direct[rows]
    way = cheapest_chain(prover, path, price).tolist()
    return [(a, b) for a, b in itertools.pairwise(way) if b > a + 1][::-1]
