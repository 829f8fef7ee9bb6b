"""Links between near neighbours: what turns a tree, with one way between two nodes, into a graph with a choice."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from planner.arrays import Floats, Ints
from planner.collision.edges import EdgeProver
from planner.robot import Robot

NEIGHBOURS = 20
_BATCH = 256  # candidates proven at a time; the order of acceptance does not depend on it
_ROWS = 512  # rows of the distance matrix at a time


def nearest_neighbours(robot: Robot, nodes: Floats, count: int) -> tuple[Ints, Floats]:
    """The ``count`` nearest others of every node, nearest first: indices and joint distances, (n, count)."""
    n = len(nodes)
    count = min(count, n - 1)
    order = np.empty((n, max(count, 0)), dtype=np.int64)
    length = np.empty(order.shape)
    for first in range(0, n, _ROWS):
        rows = np.arange(first, min(first + _ROWS, n))
        apart = np.linalg.norm(robot.difference(nodes[rows, None], nodes[None]), axis=2)
        apart[np.arange(len(rows)), rows] = np.inf
        near = np.argsort(apart, axis=1, kind="stable")[:, :count]
        order[rows] = near
        length[rows] = np.take_along_axis(apart, near, axis=1)
    return order, length


def candidate_links(robot: Robot, nodes: Floats, edges: Ints, neighbours: int = NEIGHBOURS) -> Ints:
    """Pairs (k, 2) worth proving, in order: everyone's nearest neighbour first, then everyone's second nearest."""
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
    robot: Robot,
    prover: EdgeProver,
    nodes: Floats,
    edges: Ints,
    target: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
    stop: Callable[[], bool] = lambda: False,
) -> Ints:
    """``edges`` and proven links between near neighbours, until there are ``target`` edges or no candidate is left."""
    accepted = [edges.reshape(-1, 2)]
    count = len(edges)
    candidates = candidate_links(robot, nodes, edges)
    for first in range(0, len(candidates), _BATCH):
        if count >= target or stop():
            break
        pairs = candidates[first : first + _BATCH]
        a, b = nodes[pairs[:, 0]], nodes[pairs[:, 1]]
        free = pairs[prover.prove(a, robot.difference(a, b)).free][: target - count]
        accepted.append(free)
        count += len(free)
        progress(count, target)
    return np.concatenate(accepted)
