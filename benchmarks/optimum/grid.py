"""The cheapest path of a planar arm on a grid that grows finer around it, pulled tight: within its step of the optimum.

Dijkstra on a coarse grid of all configurations finds which way round is best. In a tube around that path the grid is
then halved, again and again, and at last the path is pulled tight: the cheapest chain of straight motions through its
points, so that the grid's own directions do not count. Edges of the grid are proven free by the clearance at their
ends, chords of the pulled path are sampled every 0.002 rad.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from benchmarks.optimum.arms import PlanarArm
from planner.base.arrays import Floats, Ints, lengths_along
from planner.cost.scale import CostScale

_COARSE = {2: 0.015, 3: 0.1}  # rad: the first grid's step, by the number of joints
_STENCIL = {2: 5, 3: 2}  # steps in each direction to the farthest neighbours
_HALVINGS = {2: 7, 3: 4}  # of the step
_TUBE = 3  # its width on either side, in new steps
_PULLED = 160  # points of the last path that it is pulled tight through, at most
_SAMPLED = 2e-3  # rad: between two states of a chord
_SHARES = (np.arange(32) + 0.5) / 32  # of a chord, at which its cost is taken


def grid_optimum(arm: PlanarArm, beta: float, scale: CostScale) -> tuple[Floats, float]:
    """The cheapest path (k, n) found from the arm's start to its goal, and its own error.

    The error, relative, is what the last halving of the step changed: the next ones would change less.
    """
    step, dof = _COARSE[len(arm.start)], len(arm.start)
    low, high = (np.ceil((-arm.limits - arm.start) / step), np.floor((arm.limits - arm.start) / step))
    axes = [np.arange(a, b + 1).astype(np.int64) for a, b in zip(low, high, strict=True)]
    cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dof)
    path = before = _cheapest(arm, beta, scale, cells, step)
    around = np.array(list(itertools.product(range(-_TUBE, _TUBE + 1), repeat=dof)))
    for _ in range(_HALVINGS[dof]):
        step, before = 0.5 * step, path
        centres = np.unique(np.rint((_dense(path, step) - arm.start) / step).astype(np.int64), axis=0)
        cells = np.unique((centres[:, None] + around).reshape(-1, dof), axis=0)
        cells = cells[(np.abs(arm.start + step * cells) <= arm.limits).all(axis=1)]
        path = _cheapest(arm, beta, scale, cells, step)
    coarser, finer = (_pull_tight(arm, beta, scale, each) for each in (before, path))
    cost = path_cost(arm, beta, scale, finer)
    return finer, abs(path_cost(arm, beta, scale, coarser) / cost - 1.0)


def path_cost(arm: PlanarArm, beta: float, scale: CostScale, path: Floats) -> float:
    """The cost of a path (k, n), integrated finely: rad at beta 1."""
    q = _dense(path, _SAMPLED)
    middle = 0.5 * (q[1:] + q[:-1])
    return float((arm.rate(middle, beta, scale) * np.linalg.norm(np.diff(q, axis=0), axis=1)).sum())


def _dense(path: Floats, step: float) -> Floats:
    """States (k, n) along a path, no farther apart than ``step``."""
    rows = [path[:1]]
    for a, b in itertools.pairwise(path):
        count = max(1, math.ceil(float(np.linalg.norm(b - a)) / step))
        rows.append(a + (np.arange(1, count + 1) / count)[:, None] * (b - a))
    return np.concatenate(rows)


def _cheapest(arm: PlanarArm, beta: float, scale: CostScale, cells: Ints, step: float) -> Floats:
    """The cheapest path (k, n) over the free ones of ``cells`` (m, n), multiples of ``step`` from the start."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import dijkstra

    q = arm.start + step * cells
    clearance = arm.clearance(q)
    free = clearance > 0
    cells, q, clearance = cells[free], q[free], clearance[free]
    low = cells.min(axis=0) - 8
    size = cells.max(axis=0) - low + 8
    strides = np.array([int(np.prod(size[k + 1 :])) for k in range(len(size))])
    keys = ((cells - low) * strides).sum(axis=1)
    order = np.argsort(keys)
    cells, q, keys, clearance = cells[order], q[order], keys[order], clearance[order]
    tails, heads = [], []
    for offset in _offsets(len(size)):
        ahead = (offset * strides).sum()
        rows = np.searchsorted(keys, keys + ahead)
        there = np.flatnonzero((rows < len(keys)) & (keys[np.minimum(rows, len(keys) - 1)] == keys + ahead))
        tails.append(there)
        heads.append(rows[there])
    start = int(np.flatnonzero((cells == 0).all(axis=1))[0])
    near = np.flatnonzero(np.linalg.norm(q - arm.goal, axis=1) <= 2.0 * math.sqrt(len(size)) * step)
    tail, head = np.concatenate([*tails, near]), np.concatenate([*heads, np.full(len(near), len(q))])
    q, clearance = np.vstack([q, arm.goal]), np.append(clearance, arm.clearance(arm.goal[None]))
    kept = arm.motion(q[head] - q[tail]) < clearance[tail] + clearance[head]  # proven free: no sample is missed
    tail, head = tail[kept], head[kept]
    middle, length = 0.5 * (q[tail] + q[head]), np.linalg.norm(q[head] - q[tail], axis=1)
    rate = (arm.rate(q[tail], beta, scale) + 4.0 * arm.rate(middle, beta, scale) + arm.rate(q[head], beta, scale)) / 6.0
    graph = csr_matrix((length * rate, (tail, head)), shape=(len(q), len(q)))
    _, back = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    rows = [len(q) - 1]
    while rows[-1] != start:
        rows.append(int(back[rows[-1]]))
        if rows[-1] < 0:
            raise ValueError(f"no path of {arm.name} on a grid of {step:g} rad")
    return q[rows[::-1]]


def _offsets(dof: int) -> Ints:
    """Half of the directions in which a cell has neighbours: no two the same, none the opposite of another."""
    found = []
    for offset in itertools.product(range(-_STENCIL[dof], _STENCIL[dof] + 1), repeat=dof):
        if offset > (0,) * dof and math.gcd(*offset) == 1:
            found.append(offset)
    return np.array(found)


def _pull_tight(arm: PlanarArm, beta: float, scale: CostScale, path: Floats) -> Floats:
    """The cheapest chain of free straight motions through points of ``path``."""
    along = lengths_along(path)
    points = path[np.unique(np.searchsorted(along, np.linspace(0.0, along[-1], _PULLED)).clip(0, len(path) - 1))]
    total, back = np.zeros(len(points)), np.zeros(len(points), dtype=np.int64)
    for j in range(1, len(points)):
        motion = points[j] - points[:j]
        states = points[:j, None] + _SHARES[:, None] * motion[:, None]
        rate = arm.rate(states.reshape(-1, states.shape[2]), beta, scale).reshape(j, -1).mean(axis=1)
        reached = total[:j] + rate * np.linalg.norm(motion, axis=1)
        for i in np.argsort(reached):
            if i == j - 1 or (arm.clearance(_dense(points[[i, j]], _SAMPLED)) > 0).all():
                total[j], back[j] = reached[i], i
                break
    rows = [len(points) - 1]
    while rows[-1]:
        rows.append(int(back[rows[-1]]))
    return points[rows[::-1]]
