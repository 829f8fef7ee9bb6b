"""The compiled library's world: bodies and obstacles, looks at states, and proofs of motions.

Arrays are float64 in C order, angles rad, lengths m. Each may be asked by several threads at once, once it is made.
:class:`ArrayError` where arrays are not of the shapes that stand here, or hold what the library cannot use.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, so_far
from planner.native.library import NativeChain
from planner.native.loading import address as _at
from planner.native.loading import flags as _bytes
from planner.native.loading import floats as _floats
from planner.native.loading import given_back, threads
from planner.native.loading import ints as _ints
from planner.native.loading import library as _library


class NativeBounds:
    """How fast pairs and bodies of one world move at most, as :meth:`NativeWorld.bounds` has looked at it."""

    def __init__(self, arrays: tuple[Any, ...]) -> None:
        self._arrays = arrays  # which have to stay where they are
        self.addresses = tuple(map(_at, arrays))

    @property
    def left_out(self) -> Bools:
        """(pairs,) which pairs proofs leave out."""
        return self._arrays[2].astype(bool)


class NativeWorld:
    """Bodies of a robot and obstacles, added one after the other, bodies first; then the pairs that are checked.

    Every body has spheres, every obstacle targets, and ``set_pairs`` comes last: then several threads may ask.
    """

    def __init__(self, chain: NativeChain, margin: float) -> None:
        self.dof, self.joints, self.bodies, self.pairs = chain.dof, chain.joints, 0, 0
        self.handle = _library.world_new(chain.handle, margin)
        given_back(self, _library.world_free, self.handle)

    def add_hull(self, joint: int, points: Floats, radius: float) -> int:
        """The convex hull of ``points`` (k, 3), rounded by ``radius``; ``joint`` -1: an obstacle. Its number."""
        points = _floats(points, len(points), 3)
        return self._numbered(joint, 0, len(points), _at(points), radius, 0, None, 0.0)

    def add_cylinder(self, joint: int, middle: Floats, half: Floats, across: Floats) -> int:
        """A cylinder: its ``middle`` (3,), from there to a disc ``half`` (3,), two radii ``across`` (2, 3)."""
        points = _floats(np.concatenate([[middle, half], across]), 4, 3)
        return self._numbered(joint, 1, len(points), _at(points), 0.0, 0, None, 0.0)

    def add_surface(self, joint: int, hull: Floats, triangles: Floats, depth: float, radius: float = 0.0) -> int:
        """The surface of ``triangles`` (m, 3, 3), with points (k, 3) of its ``hull``, no deeper than ``depth`` below.

        The hull stands for it where that is more than ``depth`` (m) away; both are rounded by ``radius`` (m).
        """
        hull, triangles = _floats(hull, len(hull), 3), _floats(triangles, len(triangles), 3, 3)
        return self._numbered(joint, 2, len(hull), _at(hull), radius, len(triangles), _at(triangles), depth)

    def _numbered(self, joint: int, *shape: Any) -> int:
        number = _library.world_add(self.handle, joint, *shape)
        self.bodies += joint >= 0
        return number

    def take(self, other: NativeWorld, item: int) -> int:
        """What ``other``, a world of the same arm, has as number ``item``; its shape is shared. Its number here.

        With its spheres or targets, its motion and its speed limit.
        """
        number = _library.world_take(self.handle, other.handle, item)
        self.bodies += item < other.bodies
        return number

    def set_motion(
        self,
        item: int,
        times: Floats,
        turns: Floats,
        shifts: Floats,
        axes: Floats,
        rates: Floats,
        speeds: Floats,
        size: float,
    ) -> None:
        """Obstacle ``item``, in its own frame, is at ``turns`` (n, 3, 3), ``shifts`` (n, 3) at ``times`` (n,) s.

        Between two of them it turns about ``axes`` (n - 1, 3), in its own frame, at ``rates`` (n - 1,) rad/s; no point
        of it exceeds ``speeds`` (n - 1,) m/s, nor is farther than ``size`` (m) from the frame's origin. It counts as at
        time 0 wherever no time is given.
        """
        n, between = len(times), max(len(times) - 1, 0)
        poses = _floats(times, n), _floats(turns, n, 3, 3), _floats(shifts, n, 3)
        stretches = _floats(axes, between, 3), _floats(rates, between), _floats(speeds, between)
        _library.world_set_motion(self.handle, item, n, *map(_at, poses), *map(_at, stretches), size)

    def set_speed_limit(self, item: int, limit: float) -> None:
        """From time 0 on no point of obstacle ``item`` is farther than ``limit`` (m/s) times t from where it was."""
        _library.world_set_speed_limit(self.handle, item, limit)

    def set_travel(self, travel: Floats) -> None:
        """How far slides go from 0 at most (joints,) m, infinite for joints that turn.

        Reaches hold no farther: motions that go beyond are undecided.
        """
        _library.world_set_travel(self.handle, _at(_floats(travel, self.joints)))

    def add_spheres(self, item: int, centres: Floats, radii: Floats) -> None:
        """Spheres (k, 3), (k,) that together hold body ``item``, in its joint's frame."""
        centres, radii = _floats(centres, len(radii), 3), _floats(radii, len(radii))
        _library.world_add_spheres(self.handle, item, len(radii), _at(centres), _at(radii))

    def add_target(
        self, item: int, turn: Floats, shift: Floats, half: Floats, radius: float, is_cylinder: bool
    ) -> None:
        """A box of half sizes ``half`` (3,), rounded by ``radius``, that holds a part of obstacle ``item``.

        Placed by ``turn`` (3, 3) and ``shift`` (3,). A cylinder has its radius and half length in ``half[0]``, ``[2]``.
        """
        turn, shift, half = _floats(turn, 3, 3), _floats(shift, 3), _floats(half, 3)
        _library.world_add_target(self.handle, item, is_cylinder, _at(turn), _at(shift), _at(half), radius)

    def set_pairs(self, pairs: Ints, checked: Bools) -> None:
        """Pairs (n, 2) of items in the order of their numbers, and which (n,) of them are checked.

        First every body with every obstacle, body after body; then two bodies each.
        """
        n = len(pairs)
        pairs, checked = _ints(pairs, n, 2), _bytes(checked, n)
        _library.world_set_pairs(self.handle, n, _at(pairs), _at(checked))
        self.pairs = n

    def _placed(self, rotation: Floats, position: Floats) -> tuple[Floats, Floats, int]:
        """Placements as :meth:`NativeChain.placements` gives them, and of how many configurations they are."""
        frames, n = self.joints + 1, position.shape[1]
        return _floats(rotation, frames, n, 3, 3), _floats(position, frames, n, 3), n

    def bounds(self, reach: Floats, body_reach: Floats, is_static: Bools) -> NativeBounds:
        """How fast things move at most, for proofs, which take no time to read it again.

        ``reach`` (pairs, joints) bounds how fast a joint's motion changes a pair's distance, ``body_reach`` (bodies,
        joints) how fast it moves a body's points, in any configuration; pairs that are ``is_static`` are left out.
        """
        joints, pairs = self.joints, self.pairs
        arrays = _floats(reach, pairs, joints), _floats(body_reach, self.bodies, joints), _bytes(is_static, pairs)
        return NativeBounds(arrays)

    def coarse(self, rotation: Floats, position: Floats) -> Floats:
        """Lower bounds (n, pairs) on distances by spheres, for placements; inf for pairs that are not checked."""
        rotation, position, n = self._placed(rotation, position)
        bounds = np.empty((n, self.pairs))
        _library.world_coarse(self.handle, n, _at(rotation), _at(position), _at(bounds))
        return bounds

    def close(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        """Lower bounds (k,) on the distances of ``pairs`` (k,) in configurations ``rows`` (k,), by planes.

        A micrometre from the distance, and short of it by no more than dents are deep where these are farther apart
        than that; 0 where they touch. Those that are ``enough`` (k,) m need not be better.
        """
        return self._close(rotation, position, rows, pairs, enough, None)

    def planes(
        self, rotation: Floats, position: Floats, rows: Ints, pairs: Ints, enough: Floats | float = np.inf
    ) -> Floats:
        """Normals (k, 3), of no unit length, of the planes that hold best between the hulls of pairs; as :meth:`close`.

        They point from the first of a pair to the second. Where the hulls meet they separate nothing.
        """
        normals = np.empty((len(rows), 3))
        self._close(rotation, position, rows, pairs, enough, normals)
        return normals

    def _close(
        self,
        rotation: Floats,
        position: Floats,
        rows: Ints,
        pairs: Ints,
        enough: Floats | float,
        normals: Floats | None,
    ) -> Floats:
        """The bounds (k,) of :meth:`close`; fills ``normals`` (k, 3) where they are given."""
        rotation, position, n = self._placed(rotation, position)
        k = len(rows)
        rows, pairs, enough = _ints(rows, k), _ints(pairs, k), _floats(np.broadcast_to(enough, k), k)
        placed, bounds = (_at(rotation), _at(position)), np.empty(k)
        found = _at(bounds), None if normals is None else _at(normals)
        _library.world_close(self.handle, n, *placed, k, _at(rows), _at(pairs), _at(enough), threads(), *found)
        return bounds

    def first_near(self, q: Floats) -> int:
        """The first configuration of (n, dof) where a pair is no farther apart than the margin; n where none is.

        One that holds what is no finite number counts as near.
        """
        q = _floats(q, len(q), self.dof)
        return _library.world_first_near(self.handle, len(q), _at(q))

    def look(self, bounds: NativeBounds, step: float) -> Callable[[Floats, Floats], bool]:
        """Whether :meth:`first_near` finds nothing along a motion, from a start by a delta (dof,), but at its start.

        In its end, its middle, and states between which no point moves further than ``step`` (m), but for those that
        lie as near to one that was looked at as it is clear. ``bounds`` are what :meth:`bounds` of this world makes.
        One thread asks it, of many motions.
        """
        dof, here = self.dof, np.empty((2, self.dof))
        start, delta = here
        handle = _library.glance_new(self.handle)
        ask, (reach, body_reach, _) = _library.glance_looks_free, bounds.addresses
        known = handle, reach, body_reach, _at(start), _at(delta), step

        def look(first: Floats, by: Floats, holds: Any = (self, bounds, here)) -> bool:
            start[:], delta[:] = _floats(first, dof), _floats(by, dof)
            return ask(*known) == 1

        given_back(look, _library.glance_free, handle)
        return look

    def proof(self, bounds: NativeBounds, room: float) -> Callable[[Floats, Floats], tuple[float, int] | None]:
        """Of one straight motion after the other, from a start by a delta (dof,), what :meth:`prove` says of it.

        Its clearance and how many samples it took; None where it is not proven. One thread asks it.
        """
        dof, piece = self.dof, np.empty((2, self.dof))
        verdict, pair, samples = np.empty((3, 1), dtype=np.int64)
        clearance, where = np.empty((2, 1))
        ask, found = _library.world_prove, (verdict, pair, samples, clearance, where)
        known = self.handle, *bounds.addresses, _at(piece), None, 1, 1, room, 1, *map(_at, found)

        def prove(first: Floats, by: Floats, holds: Any = (self, bounds, pair, where)) -> tuple[float, int] | None:
            piece[0], piece[1] = _floats(first, dof), _floats(by, dof)
            ask(*known)
            return None if verdict[0] else (float(clearance[0]), int(samples[0]))

        return prove

    def prove(
        self, bounds: NativeBounds, coefficients: Floats, room: float, spans: Floats | None = None
    ) -> tuple[Ints, Ints, Ints, Floats, Floats]:
        """Proofs of pieces q(s) = sum_k c_k s^k, ``coefficients`` (m, degree + 1, dof), s in [0, 1].

        ``bounds`` are what :meth:`bounds` of this very world makes.
        ``spans`` (m, 3), where obstacles move: when a piece begins, how long it takes, and by how much it may begin
        sooner or later, s. Verdicts (m,), the pairs that stopped them, samples, clearances and where they stopped.
        Pieces that hold what is no finite number, or that move a point farther than a million metres, are undecided.
        """
        m = len(coefficients)
        coefficients = _floats(coefficients, m, coefficients.shape[1], self.dof)
        spans = None if spans is None else _floats(spans, m, 3)
        verdict, pair, samples = (np.empty(m, dtype=np.int64) for _ in range(3))
        clearance, where = np.empty(m), np.empty(m)
        _library.world_prove(
            self.handle, *bounds.addresses, _at(coefficients),
            None if spans is None else _at(spans), m, coefficients.shape[1] - 1, room, threads(),
            *(_at(array) for array in (verdict, pair, samples, clearance, where)),
        )  # fmt: skip
        return verdict, pair, samples, clearance, where

    def prove_together(
        self, bounds: NativeBounds, coefficients: Floats, room: float, spans: Floats | None = None
    ) -> tuple[Ints, Ints, Floats]:
        """As :meth:`prove`, of pieces (m, degree + 1, dof) of which each lies near the ones before and behind it.

        Pairs that are far apart are cleared for many of them at once. Verdicts (m,), the pairs that stopped them and
        where; pieces behind the first that is not free are left undecided, without a pair. One thread does it all.
        """
        m = len(coefficients)
        coefficients = _floats(coefficients, m, coefficients.shape[1], self.dof)
        spans = None if spans is None else _floats(spans, m, 3)
        (verdict, pair), where = np.empty((2, m), dtype=np.int64), np.empty(m)
        _library.world_prove_together(
            self.handle, *bounds.addresses, _at(coefficients), None if spans is None else _at(spans), m,
            coefficients.shape[1] - 1, room, *map(_at, (verdict, pair, where)),
        )  # fmt: skip
        return verdict, pair, where

    def first_proven(
        self,
        bounds: NativeBounds,
        coefficients: Floats,
        motions: Ints,
        alternatives: Ints,
        begin: Ints,
        room: float,
    ) -> tuple[Ints, Floats, Ints]:
        """For each of n items the number of the first of its alternatives whose motions are all proven, or -1.

        Item k has ``alternatives[k]`` (n,) of them, of which those before ``begin[k]`` are left out; alternative j
        consists of ``motions[j]`` of the pieces ``coefficients`` (m, degree + 1, dof), one after the other. With the
        numbers (n,) clearances and samples (m,) of the motions that were chosen, -1 samples for the others. Otherwise
        as :meth:`prove`.
        """
        n, m, count = len(alternatives), len(coefficients), len(motions)
        degree = coefficients.shape[1] - 1
        coefficients, chosen = _floats(coefficients, m, degree + 1, self.dof), _ints(begin, n).copy()
        items, ends = (_ints(so_far(counts)) for counts in (alternatives, motions))
        clearance, samples = np.empty(m), np.empty(m, dtype=np.int64)
        _library.world_first_proven(
            self.handle, *bounds.addresses, _at(coefficients), m, degree, n, _at(items), count, _at(ends), room,
            threads(), _at(chosen), _at(clearance), _at(samples),
        )  # fmt: skip
        return chosen, clearance, samples

    def cheapest_chain(
        self, bounds: NativeBounds, points: Floats, price: Floats, room: float
    ) -> tuple[Ints, Floats, Ints]:
        """The rows (r,) of the cheapest chain of proven straight motions from the first of ``points`` to the last one.

        ``points`` (k, dof), of which consecutive ones are joined by proven motions; ``price`` (k, k) of the motions
        forward. With the rows clearances and samples (r - 1,) of the motions between them, -1 samples where these are
        consecutive. Otherwise as :meth:`prove`. All points where every chain has an infinite price.
        """
        k = len(points)
        points, price = _floats(points, k, self.dof), _floats(price, k, k).copy()
        rows, clearance, samples = np.empty(k, dtype=np.int64), np.empty(k), np.empty(k, dtype=np.int64)
        count = _library.world_cheapest_chain(
            self.handle, *bounds.addresses, k, _at(points), _at(price), room, threads(),
            *(_at(array) for array in (rows, clearance, samples)),
        )  # fmt: skip
        return rows[:count], clearance[1:count], samples[1:count]
