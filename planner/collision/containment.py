"""What lies wholly inside a mesh: collision libraries know meshes as surfaces, and find only what crosses them.

Where no surfaces touch, a body cannot get into a closed mesh or out of it without crossing its surface. So one look at
one point of every piece of a body settles a configuration that touches nothing, and one look at the beginning settles
a motion along which no surfaces touch.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, cumulative_sums
from planner.collision.world import World
from planner.kinematics.forward import Chain
from planner.native.compiled import NativeBoxes
from planner.robot.shapes import Body, Mesh, Shape
from planner.robot.solids import Solid, could_contain, points_of_components, shape_measures, solid_of


class Containment:
    """Which checked pairs lie one inside the other, in configurations of one world. Stateless once made.

        inside = Inside(world, chain)
        inside.pairs(q)                # (n,) the number of such a pair, -1 where there is none

    Only pairs of which one is a mesh with closed pieces, and the other small enough to lie in it, are asked about.
    Where there are none it costs nothing; a few microseconds for a configuration.
    """

    def __init__(self, world: World, chain: Chain) -> None:
        asked = _Questions.of(world)
        self._pair, self._solids, self._own = asked.pair, asked.solids, len(world.self_pairs)
        joints = np.array([item.joint if isinstance(item, Body) else 0 for item in world.items], dtype=np.int64)
        placements = np.array([item.placement for item in world.items]).reshape(-1, 4, 4)
        inner, outer = placements[asked.inner], placements[asked.outer]
        self.boxes = NativeBoxes(
            chain.native,
            joints[asked.inner],
            _apply(inner[:, :3, :3], asked.points) + inner[:, :3, 3],
            joints[asked.outer],
            outer[:, :3, :3],
            outer[:, :3, 3],
            asked.low,
            asked.high,
        )

    def among(self, kept: Bools) -> Containment:
        """The same in a world that has only those pairs (pairs,) that are ``kept``; its own pairs are numbered anew."""
        scene = int(kept.size - self._own)
        numbers = np.concatenate([np.arange(scene), scene + cumulative_sums(kept[scene:])[:-1]])
        made = copy.copy(self)
        made._pair, made._own = np.where(kept, numbers, -1)[self._pair], int(kept[scene:].sum())
        return made

    def pairs(self, q: Floats) -> Ints:
        """The number of a pair (n,) of which one lies inside the other, for configurations (n, dof); -1 for none."""
        result = np.full(len(q), -1, dtype=np.int64)
        if not (self._solids and len(q)):
            return result
        hits, local = self.boxes.hits(q)
        for k in np.unique(hits[:, 1]) if len(hits) else ():
            near = np.flatnonzero((hits[:, 1] == k) & (result[hits[:, 0]] < 0))
            held = near[self._solids[k].contains(local[near])]
            result[hits[held, 0]] = self._pair[k]
        return result

    def all_pairs(self, q: Floats) -> Ints:
        """The numbers (m,) of all such pairs that there are in any of the configurations (n, dof)."""
        if not self._solids:
            return np.zeros(0, dtype=np.int64)
        hits, local = self.boxes.hits(q)
        met = np.unique(hits[:, 1])
        held = [self._solids[k].contains(local[hits[:, 1] == k]).any() for k in met]
        found = np.unique(self._pair[met[np.array(held, dtype=bool)]])
        return found[found >= 0]


def _apply(turn: Floats, vectors: Floats) -> Floats:
    """Rotations (k, 3, 3) of vectors (k, 3)."""
    return (turn @ vectors[..., None])[..., 0]


@dataclass(frozen=True, eq=False)
class _Questions:
    """Whether ``points`` (k, 3) of the items ``inner`` (k,), in their frames, lie in the ``solids`` of ``outer`` (k,).

    These reach from ``low`` to ``high`` (k, 3).

    In the order of the pairs (k,) that are checked; their shapes are compared kind by kind, as pairs are many.
    """

    pair: Ints
    outer: Ints
    inner: Ints
    points: Floats
    solids: list[Solid]
    low: Floats
    high: Floats

    @staticmethod
    def of(world: World) -> _Questions:
        shapes = tuple(item.shape for item in world.items)
        return _questions(shapes, len(world.bodies), world.checked.tobytes(), world.self_pairs.tobytes())


@lru_cache(maxsize=16)
def _questions(items: tuple[Shape, ...], bodies: int, checked: bytes, own: bytes) -> _Questions:
    """Of items by their shapes, bodies first: where they stand does not matter, so a move asks nothing anew."""
    numbers: dict[Shape, int] = {}
    kind = np.array([numbers.setdefault(shape, len(numbers)) for shape in items], dtype=np.int64)
    shapes = list(numbers)
    known = {k: solid_of(shape) for k, shape in enumerate(shapes) if isinstance(shape, Mesh)}
    solids = {k: solid for k, solid in known.items() if solid is not None}
    measures = shape_measures(shapes)
    pair, first, second = _checked_pairs(len(items), bodies, checked, own)
    holds = np.zeros((len(shapes), len(shapes)), dtype=bool)  # [outer, inner]
    for k, solid in solids.items():
        holds[k] = could_contain(solid, measures)
    rows, outer, inner = [np.zeros(0, dtype=np.int64)], [], []
    for one, other in ((first, second), (second, first)):
        found = np.flatnonzero(holds[kind[one], kind[other]])
        rows.append(found)
        outer.append(one[found])
        inner.append(other[found])
    row = np.concatenate(rows)
    outside, held = (np.concatenate([rows[0], *part]) for part in (outer, inner))
    order = np.lexsort((outside != first[row], row))
    points = [points_of_components(shape) for shape in shapes]
    count = np.array([len(each) for each in points], dtype=np.int64)
    order = np.repeat(order, count[kind[held[order]]])
    there = [solids[k] for k in kind[outside[order]]]
    return _Questions(
        pair[row[order]],
        outside[order],
        held[order],
        np.concatenate([np.zeros((0, 3)), *(points[k] for k in kind[held[_once(order)]])]),
        there,
        np.array([solid.low for solid in there]).reshape(-1, 3),
        np.array([solid.high for solid in there]).reshape(-1, 3),
    )


def _once(order: Ints) -> Ints:
    """What is repeated in ``order`` (k,), once each."""
    return order[np.flatnonzero(np.diff(order, prepend=-1))]


def _checked_pairs(count: int, bodies: int, checked: bytes, own: bytes) -> tuple[Ints, Ints, Ints]:
    """The numbers of the pairs (k,) that are checked, and of their items (k,) each, of ``count``."""
    shape = bodies, count - bodies
    scene, self_pairs = np.frombuffer(checked, dtype=np.bool_), np.frombuffer(own, dtype=np.int64).reshape(-1, 2)
    there = np.flatnonzero(scene)
    first, second = np.unravel_index(there, shape) if len(there) else (there, there)
    return (
        np.concatenate([there, scene.size + np.arange(len(self_pairs))]),
        np.concatenate([first, self_pairs[:, 0]]),
        np.concatenate([second + bodies, self_pairs[:, 1]]),
    )
