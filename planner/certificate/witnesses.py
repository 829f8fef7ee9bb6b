"""Planes that prove pairs of hulls apart along curves: an interval is halved until one in its middle is enough.

Each witness is kept only where it satisfies the checker's own inequality, by the checker's own functions: what is
written is what will be accepted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.certificate import verify_proof as checker
from planner.certificate.geometry import Arrays, centers_of, split_shapes
from planner.kinematics.forward import Chain, joint_placements
from planner.native.compiled import NativeWorld

_DEEPEST = 40  # halvings
_TOGETHER = 20_000  # witnesses
_SHORTEST = 1e-6  # of a piece: where w keeps no floor on that much it is not looked at further
_NARROW = 0.02  # of a piece: from there on it is asked whether halving helps, which takes as long as a half
_SPARE = 1e-8  # m: beyond what the checker asks, so that shapes read from elsewhere may be rounded otherwise


@dataclass(frozen=True, eq=False)
class Tasks:
    """Intervals [``low``, ``high``] (n,) of pieces, on which pairs (n,), rows of the arrays, are to be proven apart."""

    piece: Ints
    pair: Ints
    low: Floats
    high: Floats

    def __len__(self) -> int:
        return len(self.piece)

    def of(self, rows: Ints | Bools | slice) -> Tasks:
        """Some of them."""
        return Tasks(self.piece[rows], self.pair[rows], self.low[rows], self.high[rows])

    def in_the_middle(self) -> Tasks:
        """Their middles alone."""
        middle = 0.5 * (self.low + self.high)
        return Tasks(self.piece, self.pair, middle, middle)

    @staticmethod
    def joined(parts: list[Tasks]) -> Tasks:
        """All of them."""
        return Tasks(*(np.concatenate([getattr(part, key) for part in parts]) for key in vars(parts[0])))

    def halves(self) -> Tasks:
        """Both halves of each."""
        middle = 0.5 * (self.low + self.high)
        low, high = np.concatenate([self.low, middle]), np.concatenate([middle, self.high])
        return Tasks(np.tile(self.piece, 2), np.tile(self.pair, 2), low, high)


class Search:
    """Looks for witnesses of ``pairs`` (p, 2) of items along ``pieces`` (m, 6, dof), and of the floor.

    ``rows`` is how many of the Jacobian's count for w.
    """

    def __init__(self, chain: Chain, arrays: Arrays, pairs: Ints, pieces: Floats, rows: int) -> None:
        self._chain, self._pieces, self._rows = chain, pieces, rows
        self._arrays = arrays | {"pairs": pairs, "shapes": split_shapes(arrays)}
        self._native, self._numbers = _native(chain, self._arrays)
        self._joint = np.maximum(arrays["joint"], 0)
        self._middles = centers_of(self._arrays["shapes"])
        self._reach, self._spare = checker.reaches(self._arrays, pieces)

    def run(self) -> tuple[Arrays, Bools]:
        """The witnesses' arrays, and which pairs (p,) no plane between hulls proves apart."""
        pairs = len(self._numbers)
        piece, pair = (grid.ravel() for grid in np.indices((len(self._pieces), pairs)))
        tasks = Tasks(piece, pair, np.zeros(len(piece)), np.ones(len(piece)))
        lost = np.zeros(pairs, dtype=bool)
        found: list[tuple[Tasks, Any]] = [(tasks.of(slice(0)), np.zeros((0, 3)))]
        for depth in range(_DEEPEST):
            normal, holds, hopeless = self._look(tasks, close_only=depth > 0)
            found.append((tasks.of(holds), normal[holds]))
            lost[tasks.pair[hopeless]] = True
            tasks = tasks.of(~holds & ~lost[tasks.pair]).halves()
            if not len(tasks):
                break
        lost[tasks.pair] = True
        floor, claims = self._floor()
        joined = Tasks.joined([*(part for part, _ in found), floor])
        normals = np.concatenate([*(part for _, part in found), claims])
        return _as_parts(joined, normals, np.append(lost, False), len(self._pieces)), lost

    def _floor(self) -> tuple[Tasks, Any]:
        """Intervals that cover all pieces, and normals (n, 3): of those on which w is not shown to keep its floor 0."""
        count, floor = len(self._pieces), float(self._arrays["floor"]) * (1.0 + _SPARE)
        tasks = Tasks(np.arange(count), np.full(count, len(self._numbers)), np.zeros(count), np.ones(count))
        found, kept = [tasks.of(slice(0))], [np.zeros(0, dtype=bool)]
        while len(tasks):
            least, width = self._least_w(tasks), tasks.high - tasks.low
            holds = (least >= floor) & (floor > 0)
            deeper = ~holds & (width > _SHORTEST) & (floor > 0)
            narrow = np.flatnonzero(deeper & (width < _NARROW))
            w = self._least_w(tasks.of(narrow).in_the_middle())
            deeper[narrow] = 2.0 * w - least[narrow] >= floor  # of the others no part will hold
            found.append(tasks.of(~deeper))
            kept.append(holds[~deeper])
            tasks = tasks.of(deeper).halves()
        joined, shown = Tasks.joined(found), np.concatenate(kept)
        order = np.lexsort((joined.low, joined.piece))
        joined, shown = joined.of(order), shown[order]
        last = np.append((np.diff(joined.piece) > 0) | shown[1:] | shown[:-1], True)  # of parts that are one
        return joined.of(last), np.outer(shown[last], [0.0, 0.0, 1.0])

    def _least_w(self, tasks: Tasks) -> Floats:
        data = self._arrays | vars(tasks)
        return np.concatenate(
            [
                checker.least_w(data, self._pieces, self._reach[-1], self._spare, self._rows, rows)
                for rows in np.array_split(np.arange(len(tasks)), len(tasks) // _TOGETHER + 1)
            ]
        )

    def _look(self, tasks: Tasks, close_only: bool) -> tuple[Floats, Bools, Bools]:
        """Normals (n, 3), which of them are witnesses, and which tasks no part of an interval will fulfil."""
        rotation, position, row = self._placements(tasks)
        normal = self._between_middles(tasks, rotation, position, row)
        apart, need = self._judged(tasks, normal)
        enough = self._arrays["margin"] + checker.ROUNDED * need + self._spare + _SPARE
        holds, hopeless = apart > enough, np.zeros(len(tasks), dtype=bool)
        near = np.flatnonzero(~holds & (enough < np.linalg.norm(normal, axis=1)))
        if len(near):
            asked = self._native.planes(
                rotation, position, row[near], self._numbers[tasks.pair[near]], enough[near] + _SPARE
            )
            found = np.where(asked.any(axis=1, keepdims=True), asked, [0.0, 0.0, 1.0])
            normal[near] = found / np.linalg.norm(found, axis=1, keepdims=True)
            apart = self._judged(tasks.of(near), normal[near])[0]
            holds[near] = apart > enough[near]
            hopeless[near] = apart <= (enough - need)[near]
        return normal, holds, hopeless

    def _placements(self, tasks: Tasks) -> tuple[Floats, Floats, Ints]:
        """Rotations and positions of the joints in the middles of intervals, each once, and which is each task's."""
        middle = 0.5 * (tasks.low + tasks.high)
        place, row = np.unique(tasks.piece + 0.5 * middle, return_inverse=True)
        first = np.empty(len(place), dtype=np.int64)
        first[row] = np.arange(len(row))
        s, q = middle[first, None], self._pieces[tasks.piece[first], -1]
        for k in range(self._pieces.shape[1] - 2, -1, -1):
            q = q * s + self._pieces[tasks.piece[first], k]
        return *joint_placements(self._chain, q), row

    def _between_middles(self, tasks: Tasks, rotation: Floats, position: Floats, row: Ints) -> Floats:
        """Vectors (n, 3) between the middles of what encloses the pairs."""
        first, second = (
            (rotation[self._joint[item], row] @ self._middles[item][:, :, None])[:, :, 0]
            + position[self._joint[item], row]
            for item in self._arrays["pairs"][tasks.pair].T
        )
        between = second - first
        return np.where(np.linalg.norm(between, axis=1, keepdims=True) > 1e-5, between, [0.0, 0.0, 1e-5])

    def _judged(self, tasks: Tasks, normal: Floats) -> tuple[Floats, Floats]:
        """How far apart the planes are, and how far the pairs move (n,), as the checker has it."""
        data = self._arrays | vars(tasks) | {"normal": normal.astype(np.float32)}
        parts = [
            checker.gaps_and_motions(data, self._pieces, self._reach, rows)
            for rows in np.array_split(np.arange(len(tasks)), len(tasks) // _TOGETHER + 1)
        ]
        apart, need = (np.concatenate(part) for part in zip(*parts, strict=True))
        return apart, need


def _native(chain: Chain, arrays: Arrays) -> tuple[NativeWorld, Ints]:
    """The items in the compiled library, and the numbers (p,) that the pairs have there."""
    native, bodies = NativeWorld(chain.native, 0.0), int((arrays["joint"] >= 0).sum())
    for item, ((points, radius, cylinder), middle) in enumerate(
        zip(arrays["shapes"], centers_of(arrays["shapes"]), strict=True)
    ):
        joint = int(arrays["joint"][item])
        far = np.linalg.norm(points - middle, axis=1).max() + radius
        if cylinder:
            half = 0.5 * (points[1] - points[0])
            across = radius * np.linalg.svd(half[None])[2][1:]
            native.add_cylinder(joint, middle, half, across)
        else:
            native.add_hull(joint, points, radius)
        if joint >= 0:
            native.add_spheres(item, middle[None], np.array([far]))
        else:
            native.add_target(item, np.eye(3), middle, np.zeros(3), float(far), False)
    obstacles, pairs = len(arrays["joint"]) - bodies, arrays["pairs"]
    scene = np.stack(np.meshgrid(np.arange(bodies), bodies + np.arange(obstacles), indexing="ij"), axis=-1)
    own = pairs[:, 1] < bodies
    native.set_pairs(
        np.concatenate([scene.reshape(-1, 2), pairs[own]]), np.ones(scene.shape[0] * obstacles + own.sum(), dtype=bool)
    )
    numbers = pairs[:, 0] * obstacles + pairs[:, 1] - bodies
    numbers[own] = bodies * obstacles + np.arange(own.sum())
    return native, numbers


def _as_parts(tasks: Tasks, normal: Any, lost: Bools, pieces: int) -> Arrays:
    """The witnesses of the pairs that are proven, in the order of pairs, pieces and intervals, as the file has them.

    Each begins where the one before it ends, so that only the ends are kept, and how many there are of each.
    """
    order = np.lexsort((tasks.low, tasks.piece, tasks.pair))
    order = order[~lost[tasks.pair[order]]]
    kept = tasks.of(order)
    parts = np.zeros((len(lost), pieces), dtype=np.int32)
    np.add.at(parts, (kept.pair, kept.piece), 1)
    return {"parts": parts[~lost], "high": kept.high, "normal": normal[order].astype(np.float32)}
