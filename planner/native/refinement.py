"""Paths that become cheaper: the compiled code finds, prices and proves a move in one call."""

from typing import NamedTuple

from planner.base.arrays import Bools, Floats, Ints
from planner.native import compiled
from planner.native.compiled import Charge, NativeBounds, NativeWorld


class ProofSettings(NamedTuple):
    """What motions are to be: cheap, by their ``charge``, and proven with ``resolution`` (m) to spare.

    ``bounds`` are those of this very world.
    """

    world: NativeWorld
    bounds: NativeBounds
    resolution: float
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


class RefinedPath(NamedTuple):
    """A ``path`` (n, dof), and clearance and samples (n - 1,) of its motions that are new, -1 samples of others.

    ``chosen`` are for each waypoint of the last sweep of a descent (those behind them mean nothing), or for each try,
    the number of what was taken, or -1.
    """

    path: Floats
    chosen: Ints
    clearance: Floats
    samples: Ints


def descend(judge: ProofSettings, descent: Descent, begin: Ints | None = None) -> tuple[RefinedPath, int, Step]:
    """The path after its waypoints moved, each to its cheapest place that is reached and left by proven motions.

    After how many sweeps, and the step of the next one. In the first sweep the ``begin`` ((n - 1) // 2,) cheapest
    places of each waypoint are left out.
    """
    found, sweeps, step = compiled.descend(*judge, *descent, begin)
    return RefinedPath(*found), sweeps, Step(*step)


def even_stretches(judge: ProofSettings, stretches: EvenStretches, begin: int = 0) -> RefinedPath:
    """The path after all tries: each takes the stretch that gains most of those whose motions are then proven.

    The ``begin`` best ones of the first try are left out.
    """
    return RefinedPath(*compiled.even_stretches(*judge, *stretches, begin))
