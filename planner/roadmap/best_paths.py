"""Refined paths: the roadmap's best paths, made better conditioned or shorter and added to the roadmap.

RRT fills the space without regard to cost, so few of its nodes lie where a good path would pass. Once the roadmap has
grown, its best path for each of a few betas is refined: waypoint by waypoint it moves to lower cost, integrated along
its edges, over proven motions only. The refined waypoints become nodes of the roadmap, and their motions edges. So the
roadmap favours well-conditioned configurations; these nodes count towards its size, so fewer are left for the rest of
the space.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.polylines import cut, parts_of
from planner.base.products import product
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import EXTRA_CLEARANCE
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability
from planner.roadmap.forest import Forest
from planner.roadmap.measure import simpson_weights
from planner.roadmap.scale import CostScale, manipulability_cost, measure_scale
from planner.world.robot import Robot

BETAS = (0.0, 0.25, 1.0)  # with a refined path: both extremes, and where much w is gained for little length
_PIECES = (1.0, 0.5)  # rad: long pieces first move the path as a whole
_SWEEPS = 12  # per length of piece; each moves every second waypoint
_DROP_EVERY = 6  # sweeps between attempts to remove waypoints
_LEAST_STEP = 0.05  # of the length of piece: refinement stops when its steps are smaller
_STEPS = (1.0, 0.5, 0.25, 0.1)  # downhill, in step sizes
_TOWARDS_MIDDLE = (1.0, 0.5)  # and towards the middle of the neighbours, which is downhill in length
_BOTH = ((0.5, 0.5), (0.5, 0.25))
_DIP = 0.5  # a motion dips where w falls below this share of what it is at its ends
_DIP_SHARES = np.linspace(0.0, 1.0, 33)
_PROVEN_PER_WAYPOINT = 2  # of its candidates, the best ones are proven
_LEAST_GAIN = 1e-4  # relative
_EPS = 1e-3  # rad, finite differences
_SHARES = np.linspace(0.0, 1.0, 5)  # of a motion at which w is sampled
_WEIGHTS = simpson_weights(len(_SHARES))


@dataclass(frozen=True, eq=False)
class MotionCost:
    """The cost of straight motions: (1 - beta) times omega integrated over their length, and beta times the length.

    Lengths are joint motion (rad). A motion with a state below manipulability ``floor`` costs infinitely much.
    """

    robot: Robot
    scale: CostScale
    beta: float
    floor: float = 0.0

    def __call__(self, a: Floats, b: Floats) -> Floats:
        """(k,) costs from configurations ``a`` (k, dof) to ``b`` (k, dof), angles unwound."""
        delta = b - a
        length = np.linalg.norm(delta, axis=1)
        if self.beta == 1.0 and self.floor <= 0:
            return length
        states = (a[:, None] + _SHARES[:, None] * delta[:, None]).reshape(-1, self.robot.dof)
        w = manipulability(self.robot, states).reshape(-1, len(_SHARES))
        cost = length * ((1.0 - self.beta) * product(manipulability_cost(w, self.scale), _WEIGHTS) + self.beta)
        return np.where(w.min(axis=1, initial=np.inf) < self.floor, np.inf, cost)


def refine_path(prover: EdgeProver, path: Floats, cost: MotionCost, progress: Progress = QUIET) -> Iterator[Floats]:
    """A path (k, dof) of proven motions moved downhill, its ends kept; first in long pieces, then in shorter ones.

    Every motion of the results is proven if those of ``path`` are; angles unwound. No randomness.
    """
    path = prover.robot.unwound(path)
    for piece in _PIECES:
        # part of a proven motion is proven
        path = cut(path, parts_of(np.linalg.norm(np.diff(path, axis=0), axis=1), piece))
        size = 0.5 * piece
        for sweep in range(_SWEEPS):
            if progress.stopped:
                return
            if size < _LEAST_STEP * piece:
                break
            if sweep % _DROP_EVERY == 0:
                path = _without_needless(prover, path, cost, piece)
            inner = np.arange(1 + sweep % 2, len(path) - 1, 2)
            if len(inner):
                moved = _move(prover, path, inner, cost, size)
                size *= 1.0 if moved.mean() >= 0.3 else 0.7
        yield path.copy()


def _without_needless(prover: EdgeProver, path: Floats, cost: MotionCost, piece: float) -> Floats:
    """The path without waypoints whose neighbours a cheaper proven motion joins that is at most 1.3 ``piece`` long."""
    for first in (1, 2):
        inner = np.arange(first, len(path) - 1, 2)
        a, q, b = path[inner - 1], path[inner], path[inner + 1]
        gain = (np.linalg.norm(b - a, axis=1) <= 1.3 * piece) & (cost(a, b) < cost(a, q) + cost(q, b))
        if gain.any():
            free = prover.prove(a[gain], (b - a)[gain], EXTRA_CLEARANCE).free
            path = np.delete(path, inner[gain][free], axis=0)
    return path


def _move(prover: EdgeProver, path: Floats, inner: Ints, cost: MotionCost, size: float) -> Bools:
    """Move waypoints ``inner``, no two of them neighbours, where that is cheaper and proven; changes ``path``."""
    before, here, after = path[inner - 1], path[inner], path[inner + 1]
    now, downhill = _slope(before, here, after, cost)
    candidates = _candidates(prover.robot, before, here, after, size * downhill)
    k, count, dof = candidates.shape
    flat = candidates.reshape(-1, dof)
    price = cost(np.repeat(before, count, axis=0), flat) + cost(flat, np.repeat(after, count, axis=0))
    price = price.reshape(k, count)
    best = np.argsort(price, axis=1, kind="stable")[:, :_PROVEN_PER_WAYPOINT]
    rows, ranks = np.nonzero(np.take_along_axis(price, best, axis=1) < now[:, None] * (1.0 - _LEAST_GAIN))
    moved = np.zeros(k, dtype=bool)
    if not len(rows):
        return moved
    there = candidates[rows, best[rows, ranks]]
    start = np.concatenate([before[rows], there])
    free = (
        prover.prove(start, np.concatenate([there, after[rows]]) - start, EXTRA_CLEARANCE)
        .free.reshape(2, -1)
        .all(axis=0)
    )
    for row, q in zip(rows[free], there[free], strict=True):  # cheapest first
        if not moved[row]:
            path[inner[row]], moved[row] = q, True
    return moved


def _slope(before: Floats, here: Floats, after: Floats, cost: MotionCost) -> tuple[Floats, Floats]:
    """The cost (k,) of the two motions at each waypoint, and the unit direction (k, dof) in which it falls fastest."""
    k, dof = here.shape
    probes = np.concatenate([here[:, None], here[:, None] + _EPS * np.eye(dof)], axis=1).reshape(-1, dof)
    price = cost(np.repeat(before, dof + 1, axis=0), probes) + cost(probes, np.repeat(after, dof + 1, axis=0))
    price = price.reshape(k, dof + 1)
    with np.errstate(invalid="ignore"):  # beside the floor a slope may be infinite: only the middle is tried there
        slope = price[:, 1:] - price[:, :1]
    slope = np.where(np.isfinite(slope), slope, 0.0)
    steepness = np.linalg.norm(slope, axis=1, keepdims=True)
    return price[:, 0], -slope / np.maximum(steepness, 1e-300) * (steepness > 0)


def _candidates(robot: Robot, before: Floats, here: Floats, after: Floats, step: Floats) -> Floats:
    """Where each waypoint might go, (k, candidates, dof), within joint limits."""
    middle = 0.5 * (before + after) - here
    moves = [share * step for share in _STEPS] + [share * middle for share in _TOWARDS_MIDDLE]
    moves += [share * middle + other * step for share, other in _BOTH]
    places = here[:, None] + np.stack(moves, axis=1)
    return np.where(robot.continuous, places, np.clip(places, robot.lower, robot.upper))


def add_refined_paths(
    prover: EdgeProver,
    nodes: Floats,
    edges: Ints,
    starts: Ints,
    goals: Ints,
    room: int,
    floor: float = 0.0,
    progress: Progress = QUIET,
) -> tuple[Floats, Ints]:
    """``nodes`` (n, dof) and proven ``edges`` (m, 2) with the refined paths of ``BETAS``, at most ``room`` nodes more.

    Nothing is added where starts and goals are not connected. With a ``floor`` (w) a path is refined only where it lies
    above the floor, and stays above it.
    """
    robot = prover.robot
    a, b = (nodes[ends] for ends in edges.T)
    scale = measure_scale(manipulability(robot, nodes), np.linalg.norm(robot.difference(a, b), axis=1), np.zeros(0))
    forest = Forest(nodes, edges)
    for beta in BETAS:
        cost = MotionCost(robot, scale, beta)
        path = best_path(nodes, edges, cost(a, a + robot.difference(a, b)), starts, goals)
        if path is None or progress.stopped:
            break
        above = np.flatnonzero(manipulability(robot, path) >= floor)
        if len(above) < 3:
            continue
        first, last = above[0], above[-1] + 1
        for refined in refine_path(prover, path[first:last], replace(cost, floor=floor), progress):
            refined = robot.normalise(_with_dips(robot, refined))
            refined[[0, -1]] = path[[first, last - 1]]  # these nodes exist already: the same to the last bit
            fresh = len({q.tobytes() for q in refined} - forest.known)
            if fresh <= room:
                forest.add_path(refined)
                room -= fresh
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
    return None if rows is None else nodes[rows]


def cheapest_nodes(n: int, arcs: Ints, cost: Floats, starts: Ints, goals: Ints) -> Ints | None:
    """The nodes (k,) of the cheapest path over ``arcs`` (m, 2) of ``n`` nodes from a start to a goal; None for none."""
    from scipy.sparse import csr_matrix  # 0.4 s to load: only where a roadmap is grown
    from scipy.sparse.csgraph import dijkstra

    graph = csr_matrix((cost, (arcs[:, 1], arcs[:, 0])), shape=(n, n))  # from goals back to starts
    cost_to_go, back, _ = dijkstra(graph, indices=goals, return_predecessors=True, min_only=True)
    here = int(starts[np.argmin(cost_to_go[starts])])
    if not np.isfinite(cost_to_go[here]):
        return None
    rows = [here]
    while back[rows[-1]] >= 0:
        rows.append(int(back[rows[-1]]))
    return np.array(rows)
