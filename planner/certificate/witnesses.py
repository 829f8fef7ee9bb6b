"""Planes that prove hulls apart along curves, by bisection of intervals.

Each witness satisfies the checker's own inequality, by the checker's own functions: the checker accepts all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.certificate import verify_proof as checker
from planner.certificate.geometry import Arrays, box_centers, split_shapes
from planner.kinematics.forward import Chain, joint_placements
from planner.native.compiled import NativeWorld

_DEEPEST = 40  # halvings
_TOGETHER = 20_000  # witnesses
_SHORTEST = 1e-6  # share of a curve: below it, a floor under w is given up
_NARROW = 0.02  # share of a curve: below it, the search first tests whether halving helps, at the price of a half
_SPARE = 1e-8  # m: beyond the checker's bound, as shapes read from other files may be rounded differently


@dataclass(frozen=True, eq=False)
class Intervals:
    """Intervals [``low``, ``high``] (n,) of curves with the pairs (n,) to be proven apart on them."""

    piece: Ints
    pair: Ints
    low: Floats
    high: Floats

    def __len__(self) -> int:
        return len(self.piece)

    def take(self, rows: Ints | Bools | slice) -> Intervals:
        """Return the intervals of these rows."""
        return Intervals(self.piece[rows], self.pair[rows], self.low[rows], self.high[rows])

    def middles(self) -> Intervals:
        """Return the middles as intervals of no length."""
        middle = 0.5 * (self.low + self.high)
        return Intervals(self.piece, self.pair, middle, middle)

    @staticmethod
    def concatenate(groups: list[Intervals]) -> Intervals:
        """Return the intervals of all groups."""
        return Intervals(*(np.concatenate([getattr(group, key) for group in groups]) for key in vars(groups[0])))

    def halves(self) -> Intervals:
        """Return both halves of each interval."""
        middle = 0.5 * (self.low + self.high)
        low, high = np.concatenate([self.low, middle]), np.concatenate([middle, self.high])
        return Intervals(np.tile(self.piece, 2), np.tile(self.pair, 2), low, high)


class Search:
    """The search for witnesses of ``pairs`` (p, 2) along ``pieces`` (m, 6, dof), and of the floor.

    ``rows`` is the number of the Jacobian's rows that w is of.
    """

    def __init__(self, chain: Chain, arrays: Arrays, pairs: Ints, pieces: Floats, rows: int) -> None:
        self._chain, self._pieces, self._rows = chain, pieces, rows
        self._arrays = arrays | {"pairs": pairs, "shapes": split_shapes(arrays)}
        self._native, self._numbers = _native(chain, self._arrays)
        self._joint = np.maximum(arrays["joint"], 0)
        self._middles = box_centers(self._arrays["shapes"])
        self._reach, self._spare = checker.reaches(self._arrays, pieces)

    def run(self) -> tuple[Arrays, Bools]:
        """Return the witnesses' arrays, and the pairs (p,) that no plane between hulls proves apart."""
        pairs = len(self._numbers)
        piece, pair = (grid.ravel() for grid in np.indices((len(self._pieces), pairs)))
        tasks = Intervals(piece, pair, np.zeros(len(piece)), np.ones(len(piece)))
        lost = np.zeros(pairs, dtype=bool)
        witnesses: list[tuple[Intervals, Any]] = [(tasks.take(slice(0)), np.zeros((0, 3)))]
        for depth in range(_DEEPEST):
            normal, holds, hopeless = self._find_planes(tasks, close_only=depth > 0)
            witnesses.append((tasks.take(holds), normal[holds]))
            lost[tasks.pair[hopeless]] = True
            tasks = tasks.take(~holds & ~lost[tasks.pair]).halves()
            if not len(tasks):
                break
        lost[tasks.pair] = True
        floor, claims = self._floor()
        intervals = Intervals.concatenate([*(each for each, _ in witnesses), floor])
        normals = np.concatenate([*(each for _, each in witnesses), claims])
        return _pack(intervals, normals, np.append(lost, False), len(self._pieces)), lost

    def _floor(self) -> tuple[Intervals, Any]:
        """Return intervals that cover all curves, and normals (n, 3): 0 where the floor is not shown."""
        count, floor = len(self._pieces), float(self._arrays["floor"]) * (1.0 + _SPARE)
        tasks = Intervals(np.arange(count), np.full(count, len(self._numbers)), np.zeros(count), np.ones(count))
        groups, claims = [tasks.take(slice(0))], [np.zeros(0, dtype=bool)]
        while len(tasks):
            least, width = self._least_w(tasks), tasks.high - tasks.low
            holds = (least >= floor) & (floor > 0)
            deeper = ~holds & (width > _SHORTEST) & (floor > 0)
            narrow = np.flatnonzero(deeper & (width < _NARROW))
            w = self._least_w(tasks.take(narrow).middles())
            deeper[narrow] = 2.0 * w - least[narrow] >= floor  # no half of the others will hold
            groups.append(tasks.take(~deeper))
            claims.append(holds[~deeper])
            tasks = tasks.take(deeper).halves()
        intervals, shown = Intervals.concatenate(groups), np.concatenate(claims)
        order = np.lexsort((intervals.low, intervals.piece))
        intervals, shown = intervals.take(order), shown[order]
        # neighbours without a claim become one interval
        last = np.append((np.diff(intervals.piece) > 0) | shown[1:] | shown[:-1], True)
        return intervals.take(last), np.outer(shown[last], [0.0, 0.0, 1.0])

    def _least_w(self, tasks: Intervals) -> Floats:
        data = self._arrays | vars(tasks)
        return np.concatenate(
            [
                checker.least_w(data, self._pieces, self._reach[-1], self._spare, self._rows, rows)
                for rows in np.array_split(np.arange(len(tasks)), len(tasks) // _TOGETHER + 1)
            ]
        )

    def _find_planes(self, tasks: Intervals, close_only: bool) -> tuple[Floats, Bools, Bools]:
        """Return normals (n, 3), which are witnesses, and which tasks are hopeless on every subinterval."""
        rotation, position, row = self._placements(tasks)
        normal = self._between_middles(tasks, rotation, position, row)
        apart, need = self._evaluate(tasks, normal)
        enough = self._arrays["margin"] + checker.ROUNDED * need + self._spare + _SPARE
        holds, hopeless = apart > enough, np.zeros(len(tasks), dtype=bool)
        near = np.flatnonzero(~holds & (enough < np.linalg.norm(normal, axis=1)))
        if len(near):
            planes = self._native.planes(
                rotation, position, row[near], self._numbers[tasks.pair[near]], enough[near] + _SPARE
            )
            planes = np.where(planes.any(axis=1, keepdims=True), planes, [0.0, 0.0, 1.0])
            normal[near] = planes / np.linalg.norm(planes, axis=1, keepdims=True)
            apart = self._evaluate(tasks.take(near), normal[near])[0]
            holds[near] = apart > enough[near]
            hopeless[near] = apart <= (enough - need)[near]
        return normal, holds, hopeless

    def _placements(self, tasks: Intervals) -> tuple[Floats, Floats, Ints]:
        """Return the distinct placements of the joints at interval middles, and the row of each task."""
        middle = 0.5 * (tasks.low + tasks.high)
        place, row = np.unique(tasks.piece + 0.5 * middle, return_inverse=True)
        first = np.empty(len(place), dtype=np.int64)
        first[row] = np.arange(len(row))
        s, q = middle[first, None], self._pieces[tasks.piece[first], -1]
        for k in range(self._pieces.shape[1] - 2, -1, -1):
            q = q * s + self._pieces[tasks.piece[first], k]
        return *joint_placements(self._chain, q), row

    def _between_middles(self, tasks: Intervals, rotation: Floats, position: Floats, row: Ints) -> Floats:
        """Return vectors (n, 3) between the centers of the pairs' boxes."""
        first, second = (
            (rotation[self._joint[item], row] @ self._middles[item][:, :, None])[:, :, 0]
            + position[self._joint[item], row]
            for item in self._arrays["pairs"][tasks.pair].T
        )
        between = second - first
        return np.where(np.linalg.norm(between, axis=1, keepdims=True) > 1e-5, between, [0.0, 0.0, 1e-5])

    def _evaluate(self, tasks: Intervals, normal: Floats) -> tuple[Floats, Floats]:
        """Return the distances of the planes and the motions of the pairs (n,), as the checker does."""
        data = self._arrays | vars(tasks) | {"normal": normal.astype(np.float32)}
        parts = [
            checker.gaps_and_motions(data, self._pieces, self._reach, rows)
            for rows in np.array_split(np.arange(len(tasks)), len(tasks) // _TOGETHER + 1)
        ]
        apart, need = (np.concatenate(part) for part in zip(*parts, strict=True))
        return apart, need


def _native(chain: Chain, arrays: Arrays) -> tuple[NativeWorld, Ints]:
    """Return the items in the compiled library, and the numbers (p,) of the pairs there."""
    native, bodies = NativeWorld(chain.native, 0.0), int((arrays["joint"] >= 0).sum())
    for item, ((points, radius, cylinder), middle) in enumerate(
        zip(arrays["shapes"], box_centers(arrays["shapes"]), strict=True)
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


def _pack(tasks: Intervals, normal: Any, lost: Bools, pieces: int) -> Arrays:
    """Return the witnesses of the proven pairs as the file has them, sorted by pair, piece and interval.

    Each begins where the one before it ends, so the file has only the ends, and the number of each.
    """
    order = np.lexsort((tasks.low, tasks.piece, tasks.pair))
    order = order[~lost[tasks.pair[order]]]
    proven = tasks.take(order)
    counts = np.zeros((len(lost), pieces), dtype=np.int32)
    np.add.at(counts, (proven.pair, proven.piece), 1)
    return {"parts": counts[~lost], "high": proven.high, "normal": normal[order].astype(np.float32)}
