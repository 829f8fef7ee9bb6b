"""What the compiled library knows of robots: one function or class for each thing, over NumPy arrays.

Arrays are float64 in C order, angles rad, lengths m. Each may be asked by several threads at once, once it is made.
:class:`ArrayError` where arrays are not of the shapes that stand here, or hold what the library cannot use.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, so_far
from planner.native.loading import address as _at
from planner.native.loading import flags as _bytes
from planner.native.loading import floats as _floats
from planner.native.loading import given_back, threads
from planner.native.loading import ints as _ints
from planner.native.loading import library as _library


class MotionPrices(NamedTuple):
    """What motions are charged.

    ``numbers`` (9,): low, high and zeta of omega, what lengths are divided by, beta, the floor under w, the longest
    motion (rad), how far apart (rad) w is looked at, and the chords (rad) along which the path of the tool is measured,
    0 where the motion of the joints is; ``kind`` of omega as in :func:`manipulability_costs`; ``at_end``: charged for
    the last state, not for the mean; ``fewest`` states per motion, an odd number; ``wraps`` (dof,): joints that turn by
    half a turn at most. The tool is a ``point`` (3,) that ``joint`` carries; ``rows`` of its Jacobian count.
    """

    numbers: Floats
    kind: int
    at_end: bool
    fewest: int
    wraps: Bools
    joint: int
    point: Floats
    rows: int


class NativeChain:
    """The joint tree of a robot; arrays as in :class:`planner.kinematics.forward.Chain`."""

    def __init__(
        self,
        parent: Ints,
        prismatic: Bools,
        rotations: Floats,
        offset: Floats,
        slide: Floats,
        axis: Floats,
        following: tuple[Ints, Floats, Floats] | None = None,
    ) -> None:
        """``following``: leader, factor and zero (joints,); without them every joint is planned."""
        self.joints = n = len(parent)
        leader, factor, zero = following or (np.arange(n), np.ones(n), np.zeros(n))
        self.dof = int(np.max(leader, initial=-1)) + 1
        vectors = [_floats(array, n, 3) for array in (offset, slide, axis)]
        arrays = _ints(parent, n), _bytes(prismatic, n), _floats(rotations, n, 3, 3, 3), *vectors
        arrays = *arrays, _ints(leader, n), _floats(factor, n), _floats(zero, n)
        self.handle = _library.chain_new(n, self.dof, *map(_at, arrays))
        given_back(self, _library.chain_free, self.handle)

    def placements(self, q: Floats) -> tuple[Floats, Floats]:
        """World rotations (joints + 1, n, 3, 3) and positions (joints + 1, n, 3) of the base and all joints."""
        n = len(q)
        q = _floats(q, n, self.dof)
        rotation, position = np.empty((self.joints + 1, n, 3, 3)), np.empty((self.joints + 1, n, 3))
        _library.chain_placements(self.handle, n, _at(q), _at(rotation), _at(position))
        return rotation, position

    def points(self, q: Floats, joint: int, point: Floats) -> Floats:
        """Positions (n, 3) of a ``point`` (3,) that ``joint`` (0: the base) carries."""
        q, point, positions = _floats(q, len(q), self.dof), _floats(point, 3), np.empty((len(q), 3))
        _library.chain_points(self.handle, len(q), _at(q), joint, _at(point), _at(positions))
        return positions

    def path_lengths(self, start: Floats, delta: Floats, pieces: Ints, joint: int, point: Floats) -> Floats:
        """Lengths (n,) of the paths of a ``point`` (3,) that ``joint`` carries, along straight joint motions.

        They go from ``start`` by ``delta`` (n, dof); chords between ``pieces`` (n,) + 1 evenly spaced states.
        """
        n = len(start)
        start, delta = _floats(start, n, self.dof), _floats(delta, n, self.dof)
        pieces, point, lengths = _ints(pieces, n), _floats(point, 3), np.empty(n)
        _library.chain_path_lengths(
            self.handle, n, _at(start), _at(delta), _at(pieces), joint, _at(point), threads(), _at(lengths)
        )
        return lengths

    def manipulability(self, q: Floats, joint: int, point: Floats, rows: int) -> Floats:
        """The volume (n,) that the first ``rows`` rows of the Jacobian of a point span; columns, where fewer."""
        return self.manipulability_along(q, np.zeros_like(q), np.zeros(1), joint, point, rows)[:, 0]

    def manipulability_along(
        self, start: Floats, delta: Floats, shares: Floats, joint: int, point: Floats, rows: int
    ) -> Floats:
        """The same (n, k) at ``start`` + share ``delta``, (n, dof) each, for each of ``shares`` (k,)."""
        n, k = len(start), len(shares)
        start, delta = _floats(start, n, self.dof), _floats(delta, n, self.dof)
        shares, point, w = _floats(shares, k), _floats(point, 3), np.empty((n, k))
        motions = n, _at(start), _at(delta), k, _at(shares)
        _library.chain_manipulability(self.handle, *motions, joint, _at(point), rows, threads(), _at(w))
        return w

    def inverse(
        self,
        seeds: Floats,
        joint: int,
        tool: Floats,
        target: Floats,
        oriented: bool,
        limits: tuple[Floats, Floats, Bools],
        iterations: int,
        turns_freely: bool = False,
        weight: float = 1.0,
    ) -> tuple[Floats, Floats, Floats]:
        """Where descents from ``seeds`` (n, dof) end that bring a ``tool`` (4, 4), carried by ``joint``, to targets.

        ``target`` (4, 4) or (n, 4, 4) in the world, only its position unless ``oriented``, and then but for a turn
        about its z axis where the tool ``turns_freely``; ``limits``: lowest, highest, and which
        joints wrap and have none, (dof,) each. Where a target cannot be reached, the descents end where ``weight``
        times metres and radians are least in squares. Ends (n, dof), distances (n,) and angles (n,) left there.
        """
        dof, ends = self.dof, _floats(seeds, len(seeds), self.dof).copy()
        tool, target = _floats(tool, 4, 4), _floats(target)
        target = _floats(
            np.broadcast_to(target, (len(ends), 4, 4)) if target.shape == (4, 4) else target, len(ends), 4, 4
        )
        frames = [_floats(part) for m in (tool, target) for part in (m[..., :3, :3], m[..., :3, 3])]
        rows = 3 if not oriented else 5 if turns_freely else 6
        lower, upper, wraps = _floats(limits[0], dof), _floats(limits[1], dof), _bytes(limits[2], dof)
        distance, angle = np.empty(len(ends)), np.empty(len(ends))
        _library.chain_inverse(
            self.handle, len(ends), _at(ends), joint, *map(_at, frames), rows, weight, _at(lower), _at(upper),
            _at(wraps), iterations, threads(), _at(distance), _at(angle),
        )  # fmt: skip
        return ends, distance, angle


class Charge:
    """What motions of an arm cost, by some ``prices``."""

    def __init__(self, chain: NativeChain, prices: MotionPrices) -> None:
        self._held = _floats(prices.numbers, 9), _floats(prices.point, 3), _bytes(prices.wraps, chain.dof)
        numbers, point, wraps = map(_at, self._held)
        tool, rules = (prices.joint, point, prices.rows), (prices.kind, prices.at_end, prices.fewest)
        self.chain, self._known = chain, (chain.handle, *tool, numbers, *rules, wraps)

    @property
    def arguments(self) -> tuple[Any, ...]:
        """The first arguments of what charges motions."""
        return *self._known, threads()

    def costs(self, start: Floats, end: Floats) -> Floats:
        """What straight motions from ``start`` to ``end`` (n, dof) cost (n,).

        As :class:`planner.cost.motion_cost.MotionCost` says.
        """
        n, dof = len(start), self.chain.dof
        start, end, costs = _floats(start, n, dof), _floats(end, n, dof), np.empty(n)
        _library.chain_motion_costs(*self.arguments, n, _at(start), _at(end), _at(costs))
        return costs


class KeptBounds(NamedTuple):
    """How far frames (f,) leave their chords at most, and what that takes from what their pieces (p,) have to spare."""

    reach: Floats  # (f, dof) m, of :meth:`planner.kinematics.tool_bound.Frame.reach`
    rates: Floats  # (f, dof, dof), how fast columns of the linear Jacobian change
    turns: Floats  # (f, dof), how fast joints turn the frame
    per_metre: Floats  # (p,)
    per_turn: Floats  # (p,)


class NativeKeeping:
    """Convex pieces of the poses y (12,) = position and rows of the rotation of frames (f,) that joints carry.

    A piece is ``row . y >= limit`` or, a ball, ``|rows y - centre| <= limit``; ``depth`` is how much more there can be.
    """

    def __init__(
        self,
        chain: NativeChain,
        joints: Ints,
        placements: Floats,
        pieces: Ints,
        counts: Ints,
        balls: Bools,
        rows: Floats,
        centres: Floats,
        limits: Floats,
        depths: Floats,
        joint_limits: tuple[Floats, Floats, Bools],
    ) -> None:
        """Frames (f,) in ``placements`` (f, 4, 4), of as many ``pieces`` (f,) each, which have ``counts`` (p,) rows.

        ``rows`` (r, 12), ``centres`` (r,), ``limits`` and ``depths`` (p,); ``joint_limits`` as those of
        :meth:`NativeChain.inverse`.
        """
        f, p, r, dof = len(joints), len(counts), len(rows), chain.dof
        self._dof, self._pieces = dof, _ints(pieces, f)
        lower, upper, wraps = joint_limits
        frames = _ints(joints, f), _floats(placements[:, :3, :3], f, 3, 3), _floats(placements[:, :3, 3], f, 3)
        ends = _ints(so_far(self._pieces), f + 1), _ints(so_far(_ints(counts, p)), p + 1)
        values = _floats(rows, r, 12), _floats(centres, r), _floats(limits, p), _floats(depths, p)
        arrays = *frames, *ends, _bytes(balls, p), *values, _floats(lower, dof), _floats(upper, dof), _bytes(wraps, dof)
        self._handle = _library.keeping_new(chain.handle, f, *map(_at, arrays))
        given_back(self, _library.keeping_free, self._handle)

    def slack(self, frame: int, rotation: Floats, position: Floats) -> Floats:
        """What the pieces (k,) of a frame have to spare (n, k) at its poses, (n, 3, 3) and (n, 3)."""
        n = len(position)
        rotation, position = _floats(rotation, n, 3, 3), _floats(position, n, 3)
        slack = np.empty((n, self._pieces[frame]))
        _library.keeping_slack(self._handle, frame, n, _at(rotation), _at(position), _at(slack))
        return slack

    def projected(self, q: Floats, depth: Floats, exact: float, steps: int) -> tuple[Floats, Bools]:
        """States near ``q`` (n, dof) that keep all but for ``exact``, and which do (n,).

        By as many steps at most, a share ``depth`` (n,) into what is allowed.
        """
        n = len(q)
        q, depth, good = _floats(q, n, self._dof).copy(), _floats(depth, n), np.empty(n, bool)
        _library.keeping_project(self._handle, n, _at(q), _at(depth), exact, steps, threads(), _at(good))
        return q, good

    def proven(self, curves: Floats, bounds: KeptBounds, forgiven: float, finest: float) -> Bools:
        """Which of the curves sum_k c_k s^k, s in [0, 1], (n, degree + 1, dof), are proven to keep all.

        But for ``forgiven``; pieces of them that leave their chords by no more than ``finest`` are not halved.
        """
        n, length, f, dof, p = *curves.shape[:2], len(self._pieces), self._dof, int(self._pieces.sum())
        shapes = (f, dof), (f, dof, dof), (f, dof), (p,), (p,)
        arrays = [_floats(array, *shape) for array, shape in zip(bounds, shapes, strict=True)]
        curves, good = _floats(curves, n, length, dof), np.empty(n, bool)
        found = *map(_at, [curves, *arrays]), forgiven, finest, threads(), _at(good)
        _library.keeping_prove(self._handle, n, length - 1, *found)
        return good


class NativeBoxes:
    """Points (k, 3) in the frames of joints ``inner`` (k,), and a box for each.

    Boxes go from ``low`` to ``high`` (k, 3) in frames ``turns`` (k, 3, 3), ``shifts`` (k, 3), which are given in those
    of joints ``outer`` (k,).
    """

    def __init__(
        self,
        chain: NativeChain,
        inner: Ints,
        points: Floats,
        outer: Ints,
        turns: Floats,
        shifts: Floats,
        low: Floats,
        high: Floats,
    ) -> None:
        self._dof, k = chain.dof, len(inner)
        boxes = [_floats(turns, k, 3, 3), *(_floats(array, k, 3) for array in (shifts, low, high))]
        inner, points, outer = _ints(inner, k), _floats(points, k, 3), _ints(outer, k)
        self.handle = _library.boxes_new(chain.handle, k, _at(inner), _at(points), _at(outer), *map(_at, boxes))
        given_back(self, _library.boxes_free, self.handle)

    def hits(self, q: Floats) -> tuple[Ints, Floats]:
        """Which points lie in their boxes in configurations (n, dof).

        Rows (m, 2) of configurations and boxes, ascending, and where the points are in the boxes' frames (m, 3).
        """
        q, room = _floats(q, len(q), self._dof), 4 * len(q)
        while True:
            rows, local = np.empty((room, 2), dtype=np.int64), np.empty((room, 3))
            found = _library.boxes_hits(self.handle, len(q), _at(q), room, _at(rows), _at(local))
            if found <= room:
                return rows[:found], local[:found]
            room = found


def manipulability_costs(w: Floats, low: float, high: float, zeta: float, kind: int) -> Floats:
    """omega elementwise: 1 up to ``low``, ``zeta`` from ``high`` on; between as 1 / w (0), -ln w (1), -w (2) goes."""
    w = _floats(w)
    costs = np.empty(w.shape)
    _library.manipulability_costs(w.size, _at(w), low, high, zeta, kind, _at(costs))
    return costs


def manipulability_cost_sums(w: Floats, weights: Floats, low: float, high: float, zeta: float, kind: int) -> Floats:
    """The sums (n,) of :func:`manipulability_costs` of w (n, k), times ``weights`` (k,)."""
    n, k = len(w), len(weights)
    w, weights, sums = _floats(w, n, k), _floats(weights, k), np.empty(n)
    _library.manipulability_cost_sums(n, k, _at(w), _at(weights), low, high, zeta, kind, _at(sums))
    return sums
