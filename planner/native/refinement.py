"""What the compiled library tries to make paths cheaper: it finds, prices and proves a move in one call.

Arrays are float64 in C order unless Ints, angles rad, lengths m. :class:`ArrayError` where arrays are not of the shapes
that stand here, or hold what the library cannot use. Motions are proven as :meth:`NativeWorld.prove` has it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

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


class Step(NamedTuple):
    """How far waypoints go in a sweep of a descent (``size``, rad), and which share of them ``moved`` in the last one.

    It shrinks where few of them move.
    """

    size: float
    moved: float = 1.0


class Descent(NamedTuple):
    """Sweeps over ``path`` (n, dof), whose waypoints move downhill: every second one from row ``first`` (1 or 2) on.

    Then those between them, and so on, until steps are below ``least``. A waypoint moves to a place that is cheaper by
    more than ``gain``, relative, and within ``limits`` (dof,) unless the joint wraps. ``mixes`` (m, 2): how much of a
    step downhill, and of the way to the middle of the neighbours; ``draws`` (sweeps, (n - 1) // 2, d, dof + 1): what is
    added to the unit direction downhill, and how much of a step is made. ``most`` for each waypoint, the cheapest.
    """

    path: Floats
    first: int
    step: Step
    least: float
    gain: float
    limits: tuple[Floats, Floats]
    mixes: Floats
    draws: Floats
    most: int


class EvenStretches(NamedTuple):
    """Tries to make ``path`` (n, dof) cheaper: some joints go a share of the way to moving evenly on a stretch of it.

    Each try has k stretches: ``ends`` (tries, k, 2) are first and last rows of the path, ``joints`` (tries, k, dof)
    which move, ``shares`` (tries, k) of the way. The ``most`` count that gain most, if that is more than ``gain``,
    relative to the whole path.
    """

    path: Floats
    ends: Ints
    joints: Bools
    shares: Floats
    gain: float
    most: int


class Refined(NamedTuple):
    """A ``path`` (n, dof), and clearance and samples (n - 1,) of its motions that are new, -1 samples of others.

    ``chosen`` are for each waypoint of the last sweep of a descent (those behind them mean nothing), or for each try,
    the number of what was taken, or -1.
    """

    path: Floats
    chosen: Ints
    clearance: Floats
    samples: Ints


def descend(judge: Judge, descent: Descent, begin: Ints | None = None) -> tuple[Refined, int, Step]:
    """The path after its waypoints moved, each to its cheapest place that is reached and left by proven motions.

    After how many sweeps, and the step of the next one. In the first sweep the ``begin`` ((n - 1) // 2,) cheapest
    places of each waypoint are left out.
    """
    dof, (path, first, step, least, gain, limits, mixes, draws, most) = judge.world.dof, descent
    n, m, sweeps, d = len(path), len(mixes), len(draws), draws.shape[2]
    k = max(0, (n - 1) // 2)
    found = _to_refine(path, dof, np.zeros(k, dtype=np.int64) if begin is None else _ints(begin, k).copy())
    mixes, draws, at = _floats(mixes, m, 2), _floats(draws, sweeps, k, d, dof + 1), np.array(step)
    lower, upper = (_floats(bound, dof) for bound in limits)
    made = _library.path_descend(
        *_known(judge), n, _at(found.path), first, sweeps, _at(at), least, gain, _at(lower), _at(upper), m, _at(mixes),
        d, _at(draws), most, *map(_at, found[1:]),
    )  # fmt: skip
    return found, made, Step(*at.tolist())


def even_stretches(judge: Judge, stretches: EvenStretches, begin: int = 0) -> Refined:
    """The path after all tries: each takes the stretch that gains most of those whose motions are then proven.

    The ``begin`` best ones of the first try are left out.
    """
    dof, (path, ends, joints, shares, gain, most) = judge.world.dof, stretches
    n, (tries, k) = len(path), shares.shape
    ends, joints, shares = _ints(ends, tries, k, 2), _bytes(joints, tries, k, dof), _floats(shares, tries, k)
    found = _to_refine(path, dof, np.empty(tries, dtype=np.int64))
    _library.path_even_stretches(
        *_known(judge), n, _at(found.path), tries, k, *map(_at, (ends, joints, shares)), gain, most, begin,
        *map(_at, found[1:]),
    )  # fmt: skip
    return found


def _to_refine(path: Floats, dof: int, chosen: Ints) -> Refined:
    """A copy of the path, which the library changes, and room for what it says of it."""
    motions = max(0, len(path) - 1)
    return Refined(_floats(path, len(path), dof).copy(), chosen, np.empty(motions), np.empty(motions, dtype=np.int64))


def _known(judge: Judge) -> tuple[Any, ...]:
    return judge.world.handle, *judge.bounds.addresses, judge.room, *judge.charge.arguments
