"""From a path of each robot to one path of all: who moves when, so that every motion is proven.

Each path is cut into steps of about equal time. A state of the search is how many steps each robot has gone (O'Donnell
and Lozano-Pérez 1989); a move lets some of the robots go one step, the others wait, and costs one. Each robot's own
motions are proven before, so a move is free if every two robots are proven apart on it: a table of each pair of robots
is filled where the search asks, and the product of the paths, or of the roadmaps, is never enumerated.
"""

import heapq
import itertools
from collections.abc import Callable, Sequence

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.collision.edge_prover import EdgeProver

_STEPS = 24  # of the longest path
_MOST = 1000  # states that the search leaves: two robots have fewer, and four pass early or not
_TILE = 4  # moves of a pair are proven for this many steps of both at once

State = tuple[int, ...]


def coordinate(paths: Sequence[Floats], velocity: Sequence[Floats], prover: EdgeProver) -> Floats | None:
    """Return a proven path (k, dof) of the composite along ``paths`` (m, own dof) of its parts, or None.

    ``velocity`` are the limits of each part's joints, which give the paths their times. All robots move at once where
    that is proven; else some wait. The search is A*: of all ways to go these steps it takes one with the fewest moves.
    """
    steps = _cut(paths, velocity)
    ends = tuple(len(rows) - 1 for rows in steps)
    pairs = _Pairs(steps, prover)
    straight = [tuple(min(k, end) for end in ends) for k in range(max(ends) + 1)]
    for states in (straight, None):
        states = states or _search(ends, pairs.is_free)
        if states is None:
            return None
        path = np.array([np.concatenate([rows[k] for rows, k in zip(steps, at, strict=True)]) for at in states])
        if prover.free(path[:-1], np.diff(path, axis=0)).all():  # the proof of all pairs, whatever the tables say
            return path
    return None


class _Pairs:
    """Which moves of two robots are proven apart, by the steps that both have gone."""

    def __init__(self, steps: Sequence[Floats], prover: EdgeProver) -> None:
        world, self.steps = prover.world, steps
        dofs = np.cumsum([0, *(rows.shape[1] for rows in steps)])
        self.columns = [slice(*dofs[k : k + 2]) for k in range(len(steps))]
        joints = np.cumsum([0, *(part.model.njoints - 1 for part in prover.robot.parts.values())])
        moved = [np.any(world.pair_reach[:, a:b], axis=1) for a, b in itertools.pairwise(joints.tolist())]
        self.provers = {
            (i, k): prover.only(np.all([moved[i], moved[k]], axis=0))
            for i, k in itertools.combinations(range(len(steps)), 2)
        }
        self.tables: dict[tuple[int, int, int, int], Bools] = {}

    def is_free(self, state: State, move: State) -> bool:
        """Return whether no two robots are in doubt on a move."""
        return all(
            self._table(i, k, state[i] // _TILE, state[k] // _TILE)[
                state[i] % _TILE, state[k] % _TILE, move[i], move[k]
            ]
            for i, k in self.provers
        )

    def _table(self, i: int, k: int, row: int, column: int) -> Bools:
        """Return (tile, tile, 2, 2) whether the moves of two robots are free from each state of a tile."""
        key = i, k, row, column
        if key not in self.tables:
            tiles = np.meshgrid(*map(np.arange, (_TILE, _TILE, 2, 2)), indexing="ij")
            a, b, *goes = (axis.ravel() for axis in tiles)
            start = np.tile(np.concatenate([rows[0] for rows in self.steps]), (len(a), 1))
            delta = np.zeros_like(start)
            for robot, at, by in ((i, a + row * _TILE, goes[0]), (k, b + column * _TILE, goes[1])):
                rows, columns, last = self.steps[robot], self.columns[robot], len(self.steps[robot]) - 1
                start[:, columns] = rows[np.minimum(at, last)]
                delta[:, columns] = rows[np.minimum(at + by, last)] - start[:, columns]
            self.tables[key] = self.provers[i, k].free(start, delta).reshape(_TILE, _TILE, 2, 2)
        return self.tables[key]


def _search(ends: State, is_free: Callable[[State, State], bool]) -> list[State] | None:
    """Return the states from all zeros to ``ends``, or None."""
    moves = sorted(itertools.product((1, 0), repeat=len(ends)), key=sum, reverse=True)[:-1]
    start: State = tuple(0 for _ in ends)
    queue = [(max(ends), 0, 0, start)]
    gone: dict[State, int] = {start: 0}
    before, count = dict[State, State](), itertools.count(1)
    closed = set[State]()
    while queue and len(closed) < _MOST:
        *_, state = heapq.heappop(queue)
        if state == ends:
            states = [state]
            while states[-1] in before:
                states.append(before[states[-1]])
            return states[::-1]
        if state in closed:
            continue
        closed.add(state)
        cost = gone[state] + 1
        for move in moves:
            other = tuple(k + by for k, by in zip(state, move, strict=True))
            left = [end - k for k, end in zip(other, ends, strict=True)]
            if min(left) >= 0 and cost < gone.get(other, np.inf) and is_free(state, move):
                gone[other], before[other] = cost, state
                heapq.heappush(queue, (cost + max(left), sum(left), next(count), other))
    return None


def _cut(paths: Sequence[Floats], velocity: Sequence[Floats]) -> list[Floats]:
    """Return each path cut into steps of about the same time, its waypoints kept."""
    takes = [
        (np.abs(np.diff(rows, axis=0)) / fastest).max(axis=1) for rows, fastest in zip(paths, velocity, strict=True)
    ]
    step = max(max(float(each.sum()) for each in takes) / _STEPS, 1e-9)
    cut = []
    for rows, seconds in zip(paths, takes, strict=True):
        pieces = [rows[:1]]
        for first, last, time in zip(rows[:-1], rows[1:], seconds.tolist(), strict=True):
            count = max(1, round(time / step))
            pieces.append(first + (last - first) * (np.arange(1, count + 1) / count)[:, None])
        cut.append(np.concatenate(pieces))
    return cut
