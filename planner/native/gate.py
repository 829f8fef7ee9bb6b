"""What the compiled library knows of chunks of joint targets: one judgement on all that a controller makes of one.

Arrays are float64 in C order, angles rad, lengths m, times s. :class:`ArrayError` for what the library cannot use.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Bools, Floats
from planner.native.library import NativeBoxes
from planner.native.loading import address as _at
from planner.native.loading import flags as _bytes
from planner.native.loading import floats as _floats
from planner.native.loading import given_back
from planner.native.loading import library as _library
from planner.native.world import NativeBounds, NativeWorld


class Judgement(NamedTuple):
    """What came of a chunk; the numbers of reasons, places and kinds are those of source/gate.hpp."""

    usable: int  # 0: something cannot be used, and nothing else is known
    pieces_made: int
    rough: int
    approached: int
    reason: int
    place: int
    piece: int
    kind: int
    joint: int
    pair: int
    touches: int
    pieces: int  # that are within limits, each with a stop
    proven: int  # of their curves
    may_hold: int


class NativeGate:
    """A world as it is, and what is asked of chunks there; several threads may ask at once.

    ``most`` (3, dof), ``lower`` and ``upper`` (dof,): limits, infinite where there is none; ``state``: the lowest and
    highest positions where the robot may be, and which joints have none, (dof,) each; ``times`` (k,): s that stops may
    take, ascending; ``apart``: how far a point at 0 s may be from the robot. Numbers beyond
    ``most`` are not used. ``is_timed``: some obstacles have speed
    limits. Curves that come nearer than ``room`` (m) to something are not proven.
    """

    def __init__(
        self,
        world: NativeWorld,
        bounds: NativeBounds,
        boxes: NativeBoxes,
        is_timed: bool,
        room: float,
        limits: tuple[Floats, Floats, Floats],
        state: tuple[Floats, Floats, Bools],
        times: Floats,
        apart: float,
        most: float,
    ) -> None:
        self.dof = dof = world.dof
        self._kept = world, bounds, boxes  # which have to stay
        asked = _floats(limits[0], 3, dof), *(_floats(row, dof) for row in (*limits[1:], *state[:2]))
        wheels, times = _bytes(state[2], dof), _floats(times, len(times))
        self._handle = _library.gate_new(
            world.handle, *bounds.addresses, boxes.handle, is_timed, room, dof, *map(_at, asked), _at(wheels),
            len(times), _at(times), apart, most,
        )  # fmt: skip
        given_back(self, _library.gate_free, self._handle)

    def check(self, points: int, rows: int, state: int, given: Floats, stop: bool) -> tuple[Judgement, Floats]:
        """Judge a number of ``points`` of so many ``rows``: positions, velocities, accelerations.

        ``given``: their times, so many rows of the robot's ``state``, positions, and so on, one after the other. With
        the judgement what :meth:`Chunk.of` takes apart.
        """
        dof, ask = self.dof, _library.gate_check
        _floats(given, points + (state + points * rows) * dof)
        made = np.empty(2 + 2 * points + (6 + points * (2 * rows + 3)) * dof)
        found = np.empty(len(Judgement._fields), dtype=np.int64)
        ask(self._handle, points, rows, state, _at(given), stop, _at(made), _at(found))
        return Judgement._make(found.tolist()), made


class Chunk(NamedTuple):
    """What joint_trajectory_controller makes of points: pieces (n, degree + 1, dof) between ``times`` (n + 1,) s.

    Until the first point's time a piece leads there from where the robot is, of the highest degree that both know the
    derivatives for. Each takes ``seconds`` (n,). ``knots`` (n + 1, 3, dof): position, velocity and acceleration with
    which the motion comes to each of the times, at the first one those of the robot. ``approach`` (2, dof) is where the
    robot is and by how much the first point, which is at 0 s, is elsewhere; None where the first piece leads there.
    """

    times: Floats
    seconds: Floats
    coefficients: Floats
    knots: Floats
    approach: Floats | None

    @staticmethod
    def of(found: Judgement, made: Floats, points: int, rows: int, dof: int) -> Chunk:
        """The arrays that :meth:`NativeGate.check` has ``made``, in the order of source/calls/chunk.hpp."""
        sizes, n = (1 + dof, points + 1, points, points * 2 * rows * dof, 3 * (points + 1) * dof), found.pieces_made
        _, times, seconds, pieces, knots, approach = np.split(made, np.cumsum(sizes))
        return Chunk(
            times[: n + 1],
            seconds[:n],
            pieces.reshape(points, 2 * rows, dof)[:n],
            knots.reshape(points + 1, 3, dof)[: n + 1],
            approach.reshape(2, dof) if found.approached else None,
        )
