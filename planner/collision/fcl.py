"""Collision checks by FCL (python-fcl); distances by separating planes."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import cached_property, lru_cache
from typing import NamedTuple

import fcl
import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.collision.bounding_volumes import widen_triangles
from planner.collision.bounds import ClearanceBound
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact, World
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.clouds import Points
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere, bounding_box

_CLEARLY = 1e-4  # m: no library reports contact for boxes farther apart
_AT_ONCE = 1 << 18  # pairs in one batch of configurations
_AT_FIRST, _GROWTH = 64, 8  # configurations: the first contact is often among the first


class _Placed(NamedTuple):
    """Boxes (k,) in configurations (n,), or fixed (1,)."""

    halves: Floats  # (k, 3) m, along their own axes
    turns: Floats  # (k, n, 3, 3) these axes, in columns
    middles: Floats  # (k, n, 3)
    along: Floats  # (k, n, 3) m, half of their extents along the world's axes
    low: Floats  # (k, 3) m, the least along these in any configuration
    high: Floats  # (k, 3) m, and the largest

    @staticmethod
    def from_halves(halves: Floats, turns: Floats, middles: Floats) -> _Placed:
        along = (np.abs(turns) @ halves[:, None, :, None])[..., 0]
        low, high = (middles - along).min(axis=1), (middles + along).max(axis=1)
        return _Placed(halves, turns, middles, along, low, high)


class Boxes:
    """An oriented bounding box around every body and obstacle of a world."""

    def __init__(self, world: World) -> None:
        boxes = np.reshape([_bounding_box(item.shape) for item in world.items], (-1, 2, 3))
        placements = np.reshape([item.placement for item in world.items], (-1, 4, 4))
        turns, count = placements[:, :3, :3], len(world.bodies)
        middles = (turns @ boxes[:, 0, :, None] + placements[:, :3, 3:])[..., 0]
        self._joints = np.array([body.joint for body in world.bodies], dtype=np.int64)
        self._halves, self._turns, self._middles = boxes[:count, 1], turns[:count], middles[:count]
        self._obstacles = _Placed.from_halves(boxes[count:, 1], turns[count:, None], middles[count:, None])
        seen = np.array([isinstance(item.shape, Points) for item in world.obstacles], dtype=bool)
        self._checked, self._own = world.checked & ~seen, world.self_pairs  # planes decide on points

    def near(self, rotation: Floats, position: Floats, reach: float) -> Iterator[tuple[Ints, Ints]]:
        """Yield checked pairs within ``reach`` (m) by their boxes: configurations and pair numbers, (k,) each.

        In ascending order of configurations and pairs, in groups of complete configurations. ``rotation`` is (joints +
        1, n, 3, 3), ``position`` (joints + 1, n, 3).
        """
        reach += _CLEARLY
        most = max(1, _AT_ONCE // max(self._checked.size + len(self._own) + len(self._joints), 1))
        first, count = 0, min(_AT_FIRST, most)
        while first < rotation.shape[1]:
            turn = rotation[self._joints, first : first + count]
            middles = (turn @ self._middles[:, None, :, None])[..., 0] + position[self._joints, first : first + count]
            bodies = _Placed.from_halves(self._halves, turn @ self._turns[:, None], middles)
            scene, own = self._near_obstacles(bodies, reach), self._near_bodies(bodies, reach)
            rows, pairs = np.append(scene[0], own[0]), np.append(scene[1], self._checked.size + own[1])
            order = np.lexsort((pairs, rows))
            yield rows[order] + first, pairs[order]
            first, count = first + count, min(_GROWTH * count, most)

    def _near_obstacles(self, bodies: _Placed, reach: float) -> tuple[Ints, Ints]:
        low, high, standing = bodies.low, bodies.high, self._obstacles
        least, largest = low.min(axis=0, initial=np.inf), high.max(axis=0, initial=-np.inf)
        some = np.flatnonzero(_overlap(least, largest, standing.low, standing.high, reach))
        swept = _overlap(low[:, None], high[:, None], standing.low[some], standing.high[some], reach)
        body, k = np.nonzero(swept & self._checked[:, some])
        rows, pairs = _near_pairs(bodies, body, standing, some[k], reach)
        return rows, (body * self._checked.shape[1] + some[k])[pairs]

    def _near_bodies(self, bodies: _Placed, reach: float) -> tuple[Ints, Ints]:
        low, high, (a, b) = bodies.low, bodies.high, self._own.T
        swept = np.flatnonzero(_overlap(low[a], high[a], low[b], high[b], reach))
        rows, pairs = _near_pairs(bodies, a[swept], bodies, b[swept], reach)
        return rows, swept[pairs]


def _overlap(low: Floats, high: Floats, least: Floats, largest: Floats, reach: float) -> Bools:
    """Return which boxes (..., 3), ``low`` to ``high`` and ``least`` to ``largest``, are within ``reach``."""
    return np.asarray(((low <= largest + reach) & (least <= high + reach)).all(axis=-1))


def _near_pairs(one: _Placed, first: Ints, other: _Placed, second: Ints, reach: float) -> tuple[Ints, Ints]:
    """Return configurations and indices of the pairs ``first``, ``second`` (k,) within ``reach``."""
    between = other.middles[second] - one.middles[first]
    near = (np.abs(between) <= one.along[first] + other.along[second] + reach).all(axis=2)
    pair, row = np.nonzero(near)
    a, b = first[pair], second[pair]
    of_other = row % other.turns.shape[1]  # the same row, or the only one
    apart = _separation(between[pair, row], one.turns[a, row], other.turns[b, of_other], one.halves[a], other.halves[b])
    return row[apart <= reach], pair[apart <= reach]


def _separation(between: Floats, first: Floats, second: Floats, half: Floats, other: Floats) -> Floats:
    """Return the largest separation (k,) m of boxes along their six axes; below 0 if they overlap.

    ``between`` (k, 3) is the vector between their centres, ``first`` and ``second`` (k, 3, 3) have their axes in
    columns, ``half`` and ``other`` (k, 3) are half sizes.
    """
    across = np.abs(first.swapaxes(1, 2) @ second)
    by_first = np.abs(first.swapaxes(1, 2) @ between[:, :, None]) - across @ other[:, :, None]
    by_second = np.abs(second.swapaxes(1, 2) @ between[:, :, None]) - across.swapaxes(1, 2) @ half[:, :, None]
    gaps = np.concatenate([by_first[..., 0] - half, by_second[..., 0] - other], axis=1)
    return gaps.max(axis=1)


@lru_cache(maxsize=1024)
def _bounding_box(shape: Shape) -> tuple[Floats, Floats]:
    """Return centre and half sizes (3,) of the bounding box of a shape, in its frame."""
    low, high = bounding_box(shape)
    return 0.5 * (low + high), 0.5 * (high - low)


_APART = 1e-12  # m: distance of pairs that neither planes nor FCL decide
_ANY_CONTACT = fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)


class FclChecker(CollisionChecker):
    """Shapes are created once and moved; FCL checks the pairs whose boxes are close."""

    name = "fcl"

    def __init__(self, world: World, known: FclChecker | None = None) -> None:
        self.world, self._alone = world, threading.Lock()
        self.chain = Chain.from_arm(world.robot)
        self.bound = ClearanceBound(world, known.bound if known else None)
        self.queries = 0
        self.second = known.second if known else []
        self._transform = fcl.Transform()  # reused: creating one takes as long as FCL's query
        self._objects: dict[int, fcl.CollisionObject] = {}  # by item number, created on demand

    @cached_property
    def _boxes(self) -> Boxes:
        return Boxes(self.world)

    def make_ready(self) -> None:
        """Create every shape that is no cloud: at joint values of 0 no pair may be near."""
        with self._alone:
            for k, item in enumerate(self.world.items):
                if not isinstance(item.shape, Points):
                    self._object(k)
        super().make_ready()

    def first_touch(self, q: Floats) -> tuple[int, Contact] | None:
        """See :class:`planner.collision.checker.CollisionChecker`; planes check simplified meshes."""
        q = np.atleast_2d(np.asarray(q, dtype=float))
        result = self._first_crossing(q)
        if not self.world.rounding.any():
            return result
        near = self.bound.first_near(q if result is None else q[: result[0]])
        return result if near is None else (near[0], self.world.contact(near[1]))

    def _first_crossing(self, q: Floats) -> tuple[int, Contact] | None:
        """Return the first contact of FCL's shapes, which ignore the rounding of simplified meshes."""
        rotation, position = joint_placements(self.chain, q)
        self.queries += len(q)
        first = self._first_touching if self.world.margin <= 0 else self._first_within_margin
        with self._alone:
            for rows, pairs in self._boxes.near(rotation, position, self.world.margin):
                result = first(rotation, position, rows, pairs)
                if result is not None:
                    return result[0], self.world.contact(result[1])
        return None

    def _first_touching(self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints) -> tuple[int, int] | None:
        """Return the first of ``pairs`` in configurations ``rows``, (k,) each, in contact."""
        for row, pair in zip(rows.tolist(), pairs.tolist(), strict=True):
            if self._touches(pair, rotation[:, row], position[:, row]):
                return row, pair
        return None

    def _first_within_margin(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints
    ) -> tuple[int, int] | None:
        """Return the nearest pair in the first configuration of ``rows`` with one within the margin."""
        enough = self.world.margin * (1 + 1e-12)
        starts = np.flatnonzero(np.diff(rows, prepend=-1))  # of each configuration's pairs
        ends = starts[2 ** np.arange(1, len(starts).bit_length()) - 1]  # one, two, four ... of them at a time
        for some in np.split(np.arange(len(rows)), ends):
            gaps = self._gaps(rotation, position, rows[some], pairs[some], 2.0 * enough)  # a bound of more is no gap
            near = np.flatnonzero(gaps <= enough)
            if len(near):
                at = near[rows[some[near]] == rows[some[near[0]]]]
                nearest = some[at[np.maximum(gaps[at], 0.0).argmin()]]
                return int(rows[nearest]), int(pairs[nearest])
        return None

    def distances_in(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        """Return distances by planes, with contact decided by FCL.

        FCL's own distances are unreliable: its GJK stopped at 20 mm for boxes 0.7 mm apart, and at 2.14 m for two
        triangles 0.62 m apart.
        """
        with self._alone:
            self.queries += len(pairs)
            return self._gaps(rotation, position, rows, pairs, enough)

    def _gaps(self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float) -> Floats:
        gaps = self.bound.close(rotation, position, rows, pairs, enough)
        for k in np.flatnonzero(gaps <= 0.0).tolist():
            if self.world.rounding[pairs[k]] == 0:
                touches = self._touches(int(pairs[k]), rotation[:, rows[k]], position[:, rows[k]])
                gaps[k] = -1.0 if touches else _APART
        return gaps

    def _touches(self, pair: int, rotation: Floats, position: Floats) -> bool:
        first, second = (self._place_item(k, rotation, position) for k in self.world.items_of(pair))
        return bool(fcl.collide(first, second, _ANY_CONTACT, fcl.CollisionResult()))

    def _place_item(self, k: int, rotation: Floats, position: Floats) -> fcl.CollisionObject:
        """Return an item by number; a body is moved to the joints."""
        item = self._object(k)
        if k < len(self.world.bodies):
            body = self.world.bodies[k]
            turn = rotation[body.joint]
            self._transform.setRotation(turn @ body.placement[:3, :3])
            self._transform.setTranslation(position[body.joint] + turn @ body.placement[:3, 3])
            item.setTransform(self._transform)
        return item

    def _object(self, k: int) -> fcl.CollisionObject:
        """Return the FCL object of an item, created on first use."""
        if k not in self._objects:
            item = self.world.items[k]
            place = fcl.Transform(item.placement[:3, :3], item.placement[:3, 3])
            self._objects[k] = fcl.CollisionObject(_geometry(item.shape), place)
        return self._objects[k]

    def error(self, distance: float) -> float:
        # planes prove the distances, formulas are exact: in 30,000 attacked pairs, some a kilometre from the origin, no
        # more than 4e-13 m, see `python -m benchmarks attack`; a micrometre leaves room for rounding farther away
        return 1e-6


@lru_cache(maxsize=1024)  # nothing changes them, and trees of triangles take time
def _geometry(shape: Shape) -> fcl.CollisionGeometry:
    match shape:
        case Box(size):
            return fcl.Box(*size)
        case Sphere(radius):
            return fcl.Sphere(radius)
        case Cylinder(radius, length):
            return fcl.Cylinder(radius, length)
        case Capsule(radius, length):
            return fcl.Capsule(radius, length)
        case Mesh():
            solid = widen_triangles(shape)
            vertices, triangles = np.array(solid.vertices), np.array(solid.triangles)
            mesh = fcl.BVHModel()
            mesh.beginModel(len(vertices), len(triangles))
            mesh.addSubModel(vertices, triangles)
            mesh.endModel()
            return mesh
