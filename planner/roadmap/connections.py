"""Links between near neighbours: they turn a tree into a graph with a choice of paths."""

from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.arm import in_one_turn
from planner.native.compiled import detours, threads
from planner.robot.robot import Robot

NEIGHBOURS = 20
LINKS = "links"  # a stage of progress
_BATCH = 256  # candidates proven at a time
_MEASURED = 8 * _BATCH  # candidates whose detour is measured first: with fewer, long detours are missed
_FEW_PAIRS = 10_000  # of nodes and queries: brute force takes less time than a tree
_MANY = 512  # queries: for fewer, threads take longer to start than they save
_LEAF = 32  # nodes in each leaf of the tree: the fastest for a thousand nodes
_LONGEST = 8.0  # times the direct distance: longer detours count alike, as they take long to measure


def nearest_neighbours(robot: Robot, nodes: Floats, count: int) -> tuple[Ints, Floats]:
    """Return indices and joint distances (n, count) of the ``count`` nearest others of every node.

    The nearest comes first.
    """
    n = len(nodes)
    count = max(min(count, n - 1), 0)
    length, order = find_nearest(robot, nodes, nodes, count + 1)
    # a node is its own nearest, unless others coincide with it
    others = np.argsort(order == np.arange(n)[:, None], axis=1, kind="stable")[:, :count]
    return np.take_along_axis(order, others, axis=1), np.take_along_axis(length, others, axis=1)


def find_nearest(robot: Robot, nodes: Floats, queries: Floats, count: int) -> tuple[Floats, Ints]:
    """Return distances and rows (k, count) of the nodes (n, dof) nearest to each of ``queries`` (k, dof).

    ``count`` is at most n.
    """
    if len(nodes) * len(queries) <= _FEW_PAIRS:
        return _nearest_of_few(robot, nodes, queries, count)
    from scipy.spatial import KDTree  # takes 0.2 s to import

    size = None
    if robot.continuous.any():  # a search in a periodic box takes three times as long
        size = np.where(robot.continuous, 2 * np.pi, 0.0)
        nodes, queries = (np.where(robot.continuous, in_one_turn(q), q) for q in (nodes, queries))
    tree = KDTree(nodes, _LEAF, boxsize=size)
    nearest: Any = [*range(1, count + 1)]  # with a list the result has a second axis even for one entry
    length, order = tree.query(queries, k=nearest, workers=threads() if len(queries) >= _MANY else 1)
    return length, np.asarray(order, dtype=np.int64)


def _nearest_of_few(robot: Robot, nodes: Floats, queries: Floats, count: int) -> tuple[Floats, Ints]:
    squares = np.zeros((len(queries), len(nodes)))
    for column in np.moveaxis(robot.difference(nodes, queries[:, None]), 2, 0):
        squares += column * column  # joint by joint: the same bits everywhere
    order = np.argsort(squares, axis=1, kind="stable")[:, :count]
    return np.sqrt(np.take_along_axis(squares, order, axis=1)), order


def candidate_links(robot: Robot, nodes: Floats, edges: Ints, neighbours: int = NEIGHBOURS) -> Ints:
    """Return pairs (k, 2) to prove: all nodes' nearest neighbours, then their second nearest, and so on."""
    order, _ = nearest_neighbours(robot, nodes, neighbours)
    n = len(nodes)
    rank_major = np.column_stack([np.tile(np.arange(n), order.shape[1]), order.T.ravel()])
    pairs = np.sort(rank_major, axis=1)
    keys = pairs[:, 0] * n + pairs[:, 1]
    known = np.sort(edges, axis=1)
    fresh = ~np.isin(keys, known[:, 0] * n + known[:, 1])
    _, first = np.unique(keys[fresh], return_index=True)
    return pairs[fresh][np.sort(first)]


def connect(
    prover: EdgeProver,
    nodes: Floats,
    edges: Ints,
    target: int,
    progress: Progress = QUIET,
) -> Ints:
    """Return ``edges`` and proven links between near neighbours, ``target`` edges at most.

    The candidates with the longest detours come first (Nieuwenhuisen and Overmars 2004): a link between siblings of a
    tree adds an edge and no choice.
    """
    robot, accepted = prover.robot, edges.reshape(-1, 2)
    if progress.stopped or len(accepted) >= target:
        return accepted
    candidates = candidate_links(robot, nodes, accepted)
    direct = _lengths(robot, nodes, candidates)
    # links only shorten paths, so a former detour is an upper bound: measure only the largest again
    detour = np.full(len(candidates), np.inf)
    while len(accepted) < target and len(candidates) and not progress.stopped:
        top = np.argsort(-detour, kind="stable")[:_MEASURED]
        if len(accepted):
            known = _lengths(robot, nodes, accepted)
            around = detours(len(nodes), accepted, known, candidates[top], _LONGEST * direct[top])
            detour[top] = np.minimum(around / np.maximum(direct[top], 1e-12), _LONGEST)
        top = top[np.argsort(-detour[top], kind="stable")]
        batch = top[_one_per_node(candidates[top], _BATCH)]
        pairs = candidates[batch]
        a, b = nodes[pairs[:, 0]], nodes[pairs[:, 1]]
        delta = robot.difference(a, b)
        free = pairs[prover.free(a, delta) & robot.is_below_half_turn(delta)][: target - len(accepted)]
        accepted = np.concatenate([accepted, free])
        left = np.ones(len(candidates), dtype=bool)
        left[batch] = False
        candidates, direct, detour = candidates[left], direct[left], detour[left]
        progress(LINKS, len(accepted), target)
    return accepted


def _one_per_node(pairs: Ints, most: int) -> list[int]:
    """Return the first ``most`` rows of ``pairs`` that share no node: a batch bridges no gap twice."""
    used: set[int] = set()
    rows: list[int] = []
    for row, (i, j) in enumerate(pairs.tolist()):
        if i not in used and j not in used:
            used.update((i, j))
            rows.append(row)
            if len(rows) == most:
                break
    return rows


def _lengths(robot: Robot, nodes: Floats, pairs: Ints) -> Floats:
    return np.linalg.norm(robot.difference(nodes[pairs[:, 0]], nodes[pairs[:, 1]]), axis=1)
