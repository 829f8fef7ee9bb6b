"""Which pairs are near enough to be asked about: those whose boxes are not clearly apart, in many configurations.

A library's own tree asks about all pairs whose bounding spheres' boxes overlap, ten times as many, by a callback each.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.collision.world import World
from planner.robot.shapes import Shape, extremes

_CLEARLY = 1e-4  # m: what boxes are farther apart touches for no library, whatever it rounds
_AT_ONCE = 1 << 18  # pairs, in all configurations that are looked at together
_AT_FIRST, _GROWTH = 64, 8  # configurations: who asks for the first contact of many often has it among the first


class _Placed(NamedTuple):
    """Boxes (k,) where they are in configurations (n,), or in all of them (1,)."""

    halves: Floats  # (k, 3) m, along their own axes
    turns: Floats  # (k, n, 3, 3) these axes, in columns
    middles: Floats  # (k, n, 3)
    along: Floats  # (k, n, 3) m, half of what they take up along the world's axes
    low: Floats  # (k, 3) m, the least along these in any configuration
    high: Floats  # (k, 3) m, and the largest

    @staticmethod
    def of(halves: Floats, turns: Floats, middles: Floats) -> _Placed:
        along = (np.abs(turns) @ halves[:, None, :, None])[..., 0]
        low, high = (middles - along).min(axis=1), (middles + along).max(axis=1)
        return _Placed(halves, turns, middles, along, low, high)


class Boxes:
    """Around everything in a world that has a shape the box, along the axes of its own frame, that holds it."""

    def __init__(self, world: World) -> None:
        boxes = np.reshape([_box(item.shape) for item in world.items], (-1, 2, 3))
        placements = np.reshape([item.placement for item in world.items], (-1, 4, 4))
        turns, count = placements[:, :3, :3], len(world.bodies)
        middles = (turns @ boxes[:, 0, :, None] + placements[:, :3, 3:])[..., 0]
        self._joints = np.array([body.joint for body in world.bodies], dtype=np.int64)
        self._halves, self._turns, self._middles = boxes[:count, 1], turns[:count], middles[:count]
        self._obstacles = _Placed.of(boxes[count:, 1], turns[count:, None], middles[count:, None])
        self._checked, self._own = world.checked, world.self_pairs

    def near(self, rotation: Floats, position: Floats, reach: float) -> Iterator[tuple[Ints, Ints]]:
        """Checked pairs that may be no farther apart than ``reach`` (m): their configurations and numbers, (k,) each.

        In ascending order of configurations and then of numbers, in groups of whole configurations. Joints are where
        ``rotation`` (joints + 1, n, 3, 3) and ``position`` (joints + 1, n, 3) have them.
        """
        reach += _CLEARLY
        most = max(1, _AT_ONCE // max(self._checked.size + len(self._own) + len(self._joints), 1))
        first, count = 0, min(_AT_FIRST, most)
        while first < rotation.shape[1]:
            turn = rotation[self._joints, first : first + count]
            middles = (turn @ self._middles[:, None, :, None])[..., 0] + position[self._joints, first : first + count]
            bodies = _Placed.of(self._halves, turn @ self._turns[:, None], middles)
            scene, own = self._near_obstacles(bodies, reach), self._near_bodies(bodies, reach)
            rows, pairs = np.append(scene[0], own[0]), np.append(scene[1], self._checked.size + own[1])
            order = np.lexsort((pairs, rows))
            yield rows[order] + first, pairs[order]
            first, count = first + count, min(_GROWTH * count, most)

    def _near_obstacles(self, bodies: _Placed, reach: float) -> tuple[Ints, Ints]:
        low, high, standing = bodies.low, bodies.high, self._obstacles
        least, largest = low.min(axis=0, initial=np.inf), high.max(axis=0, initial=-np.inf)
        some = np.flatnonzero(_meet(least, largest, standing.low, standing.high, reach))
        swept = _meet(low[:, None], high[:, None], standing.low[some], standing.high[some], reach)
        body, k = np.nonzero(swept & self._checked[:, some])
        rows, pairs = _overlapping(bodies, body, standing, some[k], reach)
        return rows, (body * self._checked.shape[1] + some[k])[pairs]

    def _near_bodies(self, bodies: _Placed, reach: float) -> tuple[Ints, Ints]:
        low, high, (a, b) = bodies.low, bodies.high, self._own.T
        swept = np.flatnonzero(_meet(low[a], high[a], low[b], high[b], reach))
        rows, pairs = _overlapping(bodies, a[swept], bodies, b[swept], reach)
        return rows, swept[pairs]


def _meet(low: Floats, high: Floats, least: Floats, largest: Floats, reach: float) -> Bools:
    """Which boxes (..., 3) from ``low`` to ``high`` are within ``reach`` of those from ``least`` to ``largest``."""
    return np.asarray(((low <= largest + reach) & (least <= high + reach)).all(axis=-1))


def _overlapping(one: _Placed, first: Ints, other: _Placed, second: Ints, reach: float) -> tuple[Ints, Ints]:
    """In which configurations which of the pairs ``first`` and ``second`` (k,) are not apart by more than ``reach``."""
    between = other.middles[second] - one.middles[first]
    near = (np.abs(between) <= one.along[first] + other.along[second] + reach).all(axis=2)
    pair, row = np.nonzero(near)
    a, b = first[pair], second[pair]
    of_other = row % other.turns.shape[1]  # the same row, or the only one
    apart = _apart(between[pair, row], one.turns[a, row], other.turns[b, of_other], one.halves[a], other.halves[b])
    return row[apart <= reach], pair[apart <= reach]


def _apart(between: Floats, first: Floats, second: Floats, half: Floats, other: Floats) -> Floats:
    """By how much (k,) m boxes are apart along that of their six axes where it is most; below 0 if they overlap.

    ``between`` (k, 3) their middles, ``first`` and ``second`` (k, 3, 3) their axes in columns, ``half`` and ``other``
    (k, 3) their half sizes along these.
    """
    across = np.abs(first.swapaxes(1, 2) @ second)
    by_first = np.abs(first.swapaxes(1, 2) @ between[:, :, None]) - across @ other[:, :, None]
    by_second = np.abs(second.swapaxes(1, 2) @ between[:, :, None]) - across.swapaxes(1, 2) @ half[:, :, None]
    gaps = np.concatenate([by_first[..., 0] - half, by_second[..., 0] - other], axis=1)
    return gaps.max(axis=1)


@lru_cache(maxsize=1024)
def _box(shape: Shape) -> tuple[Floats, Floats]:
    """Middle and half sizes (3,) of the box around a shape, in the shape's frame."""
    low, high = extremes(shape)
    return 0.5 * (low + high), 0.5 * (high - low)
