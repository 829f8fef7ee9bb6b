"""What the compiled library tries to make paths cheaper: it finds, prices and proves a move in one call.

Arrays are float64 in C order unless Ints, angles rad, lengths m. :class:`ArrayError` where arrays are not of the shapes
that stand here, or hold what the library cannot use. Motions are proven as :meth:`NativeWorld.prove` has it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.native.library import Charge
from planner.native.loading import address as _at
from planner.native.loading import flags as _bytes
from planner.native.loading import floats as _floats
from planner.native.loading import ints as _ints
from planner.native.loading import library as _library
from planner.native.world import NativeBounds, NativeWorld


class Judge(NamedTuple):
    """What motions are to be: cheap, by their ``charge``, and proven with ``room`` (m) to spare.

    ``bounds`` are what :meth:`NativeWorld.bounds` of this very world makes.
    """

    world: NativeWorld
    bounds: NativeBounds
    room: float
    charge: Charge


class WaypointMoves(NamedTuple):
    """Places for every second waypoint of ``path`` (n, dof), from row ``first`` on and but for its last one.

    A place is cheaper by more than ``gain``, relative, and within ``limits`` (dof,) unless the joint wraps. ``mixes``
    (m, 2): how much of a step of ``size`` rad downhill, and of the way to the middle of the neighbours; ``draws`` (k,
    d, dof + 1): what is added to the unit direction downhill, and how much of a step is made. ``most`` for each of the
    k waypoints, the cheapest.
    """

    path: Floats
    first: int
    size: float
    gain: float
    limits: tuple[Floats, Floats]
    mixes: Floats
    draws: Floats
    most: int


class EvenStretches(NamedTuple):
    """Stretches of ``path`` (n, dof) after some joints went a share of the way to moving evenly there.

    ``ends`` (k, 2) are first and last rows of the path, ``joints`` (k, dof) which move, ``shares`` (k,) of the way. The
    ``most`` count that gain most, if that is more than ``gain``.
    """

    path: Floats
    ends: Ints
    joints: Bools
    shares: Floats
    gain: float
    most: int


def waypoint_moves(judge: Judge, moves: WaypointMoves, begin: Ints) -> tuple[Ints, Floats, Floats, Ints]:
    """For each of k waypoints the number of its cheapest place that is reached and left by proven motions, or -1.

    The ``begin`` (k,) cheapest ones are left out. With the numbers (k,) the places (k, dof), and clearances and samples
    (k, 2) of the motions; these hold nothing where there is no place.
    """
    dof, (path, first, size, gain, limits, mixes, draws, most) = judge.world.dof, moves
    n, k, m, d = len(path), max(0, (len(path) - first) // 2), len(mixes), draws.shape[1]
    path, mixes, draws = _floats(path, n, dof), _floats(mixes, m, 2), _floats(draws, k, d, dof + 1)
    lower, upper = (_floats(bound, dof) for bound in limits)
    chosen, places = _ints(begin, k).copy(), np.empty((k, dof))
    clearance, samples = np.empty((k, 2)), np.empty((k, 2), dtype=np.int64)
    known = judge.world.handle, *judge.bounds.addresses, judge.room, *judge.charge.arguments
    _library.path_waypoint_moves(
        *known, n, _at(path), first, size, gain, _at(lower), _at(upper), m, _at(mixes), d, _at(draws), most,
        *map(_at, (chosen, places, clearance, samples)),
    )  # fmt: skip
    return chosen, places, clearance, samples


def even_stretch(
    judge: Judge, stretches: EvenStretches, begin: int
) -> tuple[int, int, Floats, float, Floats, Ints] | None:
    """The stretch that gains most whose motions are then proven, but for the ``begin`` best; None where none is.

    How many gain more, its row of k, its states (r, dof), by how much it is cheaper, and clearances and samples
    (r - 1,) of its motions.
    """
    dof, (path, ends, joints, shares, gain, most) = judge.world.dof, stretches
    n, k = len(path), len(ends)
    path, ends, joints, shares = _floats(path, n, dof), _ints(ends, k, 2), _bytes(joints, k, dof), _floats(shares, k)
    row, stretch, gained = np.zeros(1, dtype=np.int64), np.empty((n, dof)), np.empty(1)
    clearance, samples = np.empty(n), np.empty(n, dtype=np.int64)
    known = judge.world.handle, *judge.bounds.addresses, judge.room, *judge.charge.arguments
    place = _library.path_even_stretch(
        *known, n, _at(path), k, *map(_at, (ends, joints, shares)), gain, most, begin,
        *map(_at, (row, stretch, gained, clearance, samples)),
    )  # fmt: skip
    if place == 0:
        return None
    count = int(np.diff(ends[row[0]])[0])
    return place - 1, int(row[0]), stretch[: count + 1], float(gained[0]), clearance[:count], samples[:count]
