"""Links between near neighbours: what turns a tree, with one path between two nodes, into a graph with a choice."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.edge_prover import EdgeProver
from planner.world.robot import Robot, shorter_way

NEIGHBOURS = 20
_BATCH = 256  # candidates proven at a time
_MEASURED = 8 * _BATCH  # candidates whose detour is measured before: with fewer the longest ones go unseen
_SOURCES = 128  # nodes whose ways to all others are searched at a time
_ROWS = 512  # rows of the distance matrix at a time


def nearest_neighbours(robot: Robot, nodes: Floats, count: int, progress: Progress = QUIET) -> tuple[Ints, Floats]:
    """The ``count`` nearest others of every node, nearest first: indices and joint distances, (n, count).

    None, (n, 0), once ``progress`` is asked to stop.
    """
    n = len(nodes)
    count = max(min(count, n - 1), 0)
    order, length = np.empty((n, count), dtype=np.int64), np.empty((n, count))
    if not count:
        return order, length
    for first in range(0, n, _ROWS):
        if progress.stopped:
            return order[:, :0], length[:, :0]
        rows = np.arange(first, min(first + _ROWS, n))
        apart = np.zeros((len(rows), n))
        for k, joint in enumerate(nodes.T):  # one by one: small arrays stay in cache
            apart += np.square(shorter_way(joint - joint[rows, None], robot.continuous[k : k + 1]))
        apart[np.arange(len(rows)), rows] = np.inf
        near = np.argpartition(apart, count - 1, axis=1)[:, :count]
        near = np.take_along_axis(near, np.lexsort((near, np.take_along_axis(apart, near, axis=1)), axis=1), axis=1)
        order[rows], length[rows] = near, np.sqrt(np.take_along_axis(apart, near, axis=1))
    return order, length


def candidate_links(
    robot: Robot, nodes: Floats, edges: Ints, neighbours: int = NEIGHBOURS, progress: Progress = QUIET
) -> Ints:
    """Pairs (k, 2) worth proving, in order: everyone's nearest neighbour first, then everyone's second nearest."""
    order, _ = nearest_neighbours(robot, nodes, neighbours, progress)
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
    """``edges`` and proven links between near neighbours, until there are ``target`` edges or no candidate is left.

    Of all the candidates the ones go first that save the longest detour (Nieuwenhuisen and Overmars 2004): a link
    between siblings of a tree adds an edge and no choice.
    """
    robot, accepted = prover.robot, edges.reshape(-1, 2)
    candidates = candidate_links(robot, nodes, accepted, progress=progress)
    direct = _lengths(robot, nodes, candidates)
    # links only shorten paths, so a detour measured earlier is never too small: measure again only those on top
    detour = np.full(len(candidates), np.inf)
    while len(accepted) < target and len(candidates) and not progress.stopped:
        top = np.argsort(-detour, kind="stable")[:_MEASURED]
        if len(accepted):
            around = _path_lengths(robot, nodes, accepted, candidates[top], progress)
            detour[top] = around / np.maximum(direct[top], 1e-12)
        top = top[np.argsort(-detour[top], kind="stable")]
        batch = top[_one_per_node(candidates[top])][:_BATCH]
        pairs = candidates[batch]
        a, b = nodes[pairs[:, 0]], nodes[pairs[:, 1]]
        free = pairs[prover.prove(a, robot.difference(a, b)).free][: target - len(accepted)]
        accepted = np.concatenate([accepted, free])
        keep = np.ones(len(candidates), dtype=bool)
        keep[batch] = False
        candidates, direct, detour = candidates[keep], direct[keep], detour[keep]
        progress("links", len(accepted), target)
    return accepted


def _one_per_node(pairs: Ints) -> Ints:
    """Rows of ``pairs``, in order, that share no node with an earlier one: no gap is bridged twice in a batch."""
    used: set[int] = set()
    rows = []
    for row, (i, j) in enumerate(pairs.tolist()):
        if i not in used and j not in used:
            used.update((i, j))
            rows.append(row)
    return np.array(rows, dtype=np.int64)


def _lengths(robot: Robot, nodes: Floats, pairs: Ints) -> Floats:
    return np.linalg.norm(robot.difference(nodes[pairs[:, 0]], nodes[pairs[:, 1]]), axis=1)


def _path_lengths(robot: Robot, nodes: Floats, edges: Ints, pairs: Ints, progress: Progress) -> Floats:
    """Length of the shortest path through ``edges`` between the two nodes of each pair; inf where there is none.

    Once ``progress`` is asked to stop what is left is inf too.
    """
    from scipy.sparse import csr_matrix  # 0.4 s to load: only where a roadmap is linked
    from scipy.sparse.csgraph import dijkstra

    n = len(nodes)
    graph = csr_matrix((_lengths(robot, nodes, edges), (edges[:, 0], edges[:, 1])), shape=(n, n))
    sources, row = np.unique(pairs[:, 0], return_inverse=True)
    lengths = np.full(len(pairs), np.inf)
    order = np.argsort(row, kind="stable")
    for first in range(0, len(sources), _SOURCES):
        if progress.stopped:
            break
        last = min(first + _SOURCES, len(sources))
        here = order[np.searchsorted(row[order], first) : np.searchsorted(row[order], last)]
        away = dijkstra(graph, directed=False, indices=sources[first:last])
        lengths[here] = away[row[here] - first, pairs[here, 1]]
    return lengths
