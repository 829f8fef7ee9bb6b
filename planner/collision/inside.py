"""What lies wholly inside a mesh: collision libraries know meshes as surfaces, and find only what crosses them.

Where no surfaces touch, a body cannot get into a closed mesh or out of it without crossing its surface. So one look at
one point of every piece of a body settles a configuration that touches nothing, and one look at the beginning settles
a motion along which no surfaces touch.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.collision.world import World
from planner.kinematics.forward import Chain
from planner.native.library import NativeBoxes
from planner.world.shapes import Body, Mesh, Obstacle, Shape
from planner.world.solids import Solid, may_hold, points_of_pieces, solid_of


@dataclass(frozen=True, eq=False)
class _Question:
    """Whether the ``point`` (3,) of the item ``inner``, in its frame, lies in the ``solid`` of the item ``outer``."""

    pair: int
    outer: int
    inner: int
    solid: Solid
    point: Floats


class Inside:
    """Which checked pairs lie one inside the other, in configurations of one world. Stateless once made.

        inside = Inside(world, chain)
        inside.pairs(q)                # (n,) the number of such a pair, -1 where there is none

    Only pairs of which one is a mesh with closed pieces, and the other small enough to lie in it, are asked about.
    Where there are none it costs nothing; a few microseconds for a configuration.
    """

    def __init__(self, world: World, chain: Chain) -> None:
        items: list[Body | Obstacle] = [*world.bodies, *world.obstacles]
        self._questions = [one for pair in _checked_pairs(world) for one in _questions(world, pair, items)]
        joints = np.array([item.joint if isinstance(item, Body) else 0 for item in items], dtype=np.int64)
        placements = np.array([item.placement for item in items]).reshape(-1, 4, 4)
        inner = placements[[one.inner for one in self._questions]]
        outer = placements[[one.outer for one in self._questions]]
        points = np.array([one.point for one in self._questions]).reshape(-1, 3)
        self._boxes = NativeBoxes(
            chain.native,
            joints[[one.inner for one in self._questions]],
            _apply(inner[:, :3, :3], points) + inner[:, :3, 3],
            joints[[one.outer for one in self._questions]],
            outer[:, :3, :3],
            outer[:, :3, 3],
            np.array([one.solid.low for one in self._questions]).reshape(-1, 3),
            np.array([one.solid.high for one in self._questions]).reshape(-1, 3),
        )

    def pairs(self, q: Floats) -> Ints:
        """The number of a pair (n,) of which one lies inside the other, for configurations (n, dof); -1 for none."""
        result = np.full(len(q), -1, dtype=np.int64)
        if not (self._questions and len(q)):
            return result
        hits, local = self._boxes.hits(q)
        for k in np.unique(hits[:, 1]) if len(hits) else ():
            near = np.flatnonzero((hits[:, 1] == k) & (result[hits[:, 0]] < 0))
            held = near[self._questions[k].solid.contains(local[near])]
            result[hits[held, 0]] = self._questions[k].pair
        return result


def _apply(turn: Floats, vectors: Floats) -> Floats:
    """Rotations (k, 3, 3) of vectors (k, 3)."""
    return (turn @ vectors[..., None])[..., 0]


def _questions(world: World, pair: int, items: list[Body | Obstacle]) -> list[_Question]:
    first, second = world.members(pair)
    if world.is_scene_pair(pair):
        second += len(world.bodies)
    found = []
    for outer, inner in ((first, second), (second, first)):
        solid, points = _holder(items[outer].shape, items[inner].shape)
        if solid is not None:
            found += [_Question(pair, outer, inner, solid, point) for point in points]
    return found


@lru_cache(maxsize=4096)
def _holder(shape: Shape, held: Shape) -> tuple[Solid | None, Floats]:
    """The inside of ``shape`` where it may have ``held`` in it, and a point (k, 3) of each piece of that."""
    solid = solid_of(shape) if isinstance(shape, Mesh) else None
    return (solid, points_of_pieces(held)) if solid is not None and may_hold(solid, held) else (None, np.zeros((0, 3)))


def _checked_pairs(world: World) -> list[int]:
    scene = np.flatnonzero(world.checked.ravel())
    return [*scene.tolist(), *range(world.checked.size, world.checked.size + len(world.self_pairs))]
