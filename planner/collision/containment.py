"""Enclosure: bodies wholly inside closed meshes, which collision libraries treat as surfaces.

Without contact of surfaces no body can enter or leave a closed mesh. So testing one point of every connected component
settles a contact-free configuration, and testing the first configuration settles a contact-free motion.
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
    """Enclosed pairs in configurations of one world. Immutable after construction.

        inside = Containment(world, chain)
        inside.pairs(q)                # (n,) number of an enclosed pair, -1 for none

    Only pairs are tested of which one is a mesh with closed components and the other is small enough to fit inside.
    """

    def __init__(self, world: World, chain: Chain) -> None:
        queries = _Queries.from_world(world)
        self._pair, self._solids, self._own = queries.pair, queries.solids, len(world.self_pairs)
        joints = np.array([item.joint if isinstance(item, Body) else 0 for item in world.items], dtype=np.int64)
        placements = np.array([item.placement for item in world.items]).reshape(-1, 4, 4)
        inner, outer = placements[queries.inner], placements[queries.outer]
        self.boxes = NativeBoxes(
            chain.native,
            joints[queries.inner],
            (inner[:, :3, :3] @ queries.points[..., None])[..., 0] + inner[:, :3, 3],
            joints[queries.outer],
            outer[:, :3, :3],
            outer[:, :3, 3],
            queries.low,
            queries.high,
        )

    def among(self, kept: Bools) -> Containment:
        """Return the query restricted to pairs in the mask ``kept`` (pairs,); self pairs are renumbered."""
        scene = int(kept.size - self._own)
        numbers = np.concatenate([np.arange(scene), scene + cumulative_sums(kept[scene:])[:-1]])
        made = copy.copy(self)
        made._pair, made._own = np.where(kept, numbers, -1)[self._pair], int(kept[scene:].sum())
        return made

    def pairs(self, q: Floats) -> Ints:
        """Return the number (n,) of an enclosed pair for configurations (n, dof); -1 for none."""
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
        """Return the numbers (m,) of all pairs that are enclosed in any configuration (n, dof)."""
        if not self._solids:
            return np.zeros(0, dtype=np.int64)
        hits, local = self.boxes.hits(q)
        met = np.unique(hits[:, 1])
        held = [self._solids[k].contains(local[hits[:, 1] == k]).any() for k in met]
        matches = np.unique(self._pair[met[np.array(held, dtype=bool)]])
        return matches[matches >= 0]


@dataclass(frozen=True, eq=False)
class _Queries:
    """Tests whether ``points`` (k, 3) of items ``inner`` (k,) lie in ``solids`` of items ``outer`` (k,).

    ``low`` and ``high`` (k, 3) bound the solids. Ordered by ``pair`` (k,).
    """

    pair: Ints
    outer: Ints
    inner: Ints
    points: Floats
    solids: list[Solid]
    low: Floats
    high: Floats

    @staticmethod
    def from_world(world: World) -> _Queries:
        shapes = tuple(item.shape for item in world.items)
        return _make_queries(shapes, len(world.bodies), world.checked.tobytes(), world.self_pairs.tobytes())


@lru_cache(maxsize=16)
def _make_queries(items: tuple[Shape, ...], bodies: int, checked: bytes, own: bytes) -> _Queries:
    """Return the queries for item shapes, bodies first; placements do not matter, so moves reuse them."""
    numbers: dict[Shape, int] = {}
    kind = np.array([numbers.setdefault(shape, len(numbers)) for shape in items], dtype=np.int64)
    shapes = list(numbers)
    known = {k: solid_of(shape) for k, shape in enumerate(shapes) if isinstance(shape, Mesh)}
    solids = {k: solid for k, solid in known.items() if solid is not None}
    measures = shape_measures(shapes)
    pair, first, second = _pairs_to_check(len(items), bodies, checked, own)
    holds = np.zeros((len(shapes), len(shapes)), dtype=bool)  # [outer, inner]
    for k, solid in solids.items():
        holds[k] = could_contain(solid, measures)
    rows, outer, inner = [np.zeros(0, dtype=np.int64)], [], []
    for one, other in ((first, second), (second, first)):
        matches = np.flatnonzero(holds[kind[one], kind[other]])
        rows.append(matches)
        outer.append(one[matches])
        inner.append(other[matches])
    row = np.concatenate(rows)
    outside, held = (np.concatenate([rows[0], *part]) for part in (outer, inner))
    order = np.lexsort((outside != first[row], row))
    points = [points_of_components(shape) for shape in shapes]
    count = np.array([len(each) for each in points], dtype=np.int64)
    order = np.repeat(order, count[kind[held[order]]])
    inner_rows = order[np.flatnonzero(np.diff(order, prepend=-1))]  # without repetitions
    there = [solids[k] for k in kind[outside[order]]]
    return _Queries(
        pair[row[order]],
        outside[order],
        held[order],
        np.concatenate([np.zeros((0, 3)), *(points[k] for k in kind[held[inner_rows]])]),
        there,
        np.array([solid.low for solid in there]).reshape(-1, 3),
        np.array([solid.high for solid in there]).reshape(-1, 3),
    )


def _pairs_to_check(count: int, bodies: int, checked: bytes, own: bytes) -> tuple[Ints, Ints, Ints]:
    """Return the numbers (k,) of the checked pairs, and of their first and second items (k,)."""
    shape = bodies, count - bodies
    scene, self_pairs = np.frombuffer(checked, dtype=np.bool_), np.frombuffer(own, dtype=np.int64).reshape(-1, 2)
    there = np.flatnonzero(scene)
    first, second = np.unravel_index(there, shape) if len(there) else (there, there)
    return (
        np.concatenate([there, scene.size + np.arange(len(self_pairs))]),
        np.concatenate([first, self_pairs[:, 0]]),
        np.concatenate([second + bodies, self_pairs[:, 1]]),
    )
