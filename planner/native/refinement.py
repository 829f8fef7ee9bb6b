"""Refinement of paths: the compiled code chooses, prices and proves a move in one call."""

from typing import NamedTuple

from planner.base.arrays import Bools, Floats, Ints
from planner.native import compiled
from planner.native.compiled import Charge, NativeBounds, NativeWorld


class ProofSettings(NamedTuple):
    """The cost function ``charge`` of motions, and the resolution ``room`` (m) of their proofs.

    ``bounds`` are those of this very world.
    """

    world: NativeWorld
    bounds: NativeBounds
    resolution: float
    charge: Charge


class Step(NamedTuple):
    """Step size (rad) of a descent, and the share of waypoints ``moved`` in the last sweep.

    It shrinks when few move.
    """

    size: float
    moved: float = 1.0


class Descent(NamedTuple):
    """Sweeps that move every second waypoint of ``path`` (n, dof) downhill, from row ``first`` (1 or 2).

    Sweeps alternate until steps are below ``least``. A move must reduce the cost by more than ``gain``, relative,
    within ``limits`` (dof,) unless the joint wraps. ``mixes`` (m, 2): shares of a step downhill and of the way to the
    middle of the neighbours; ``draws`` (sweeps, (n - 1) // 2, d, dof + 1): additions to the unit direction downhill,
    and shares of a step. Up to ``most`` candidates per waypoint, cheapest first.
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
    """Tries to make ``path`` (n, dof) cheaper: some joints move more evenly on a stretch.

    Each try has k stretches: first and last rows ``ends`` (tries, k, 2), moving ``joints`` (tries, k, dof), and
    ``shares`` (tries, k) of the way to even motion. Up to ``most`` candidates with a gain above ``gain``, relative to
    the whole path.
    """

    path: Floats
    ends: Ints
    joints: Bools
    shares: Floats
    gain: float
    most: int


class RefinedPath(NamedTuple):
    """A ``path`` (n, dof), and clearance and samples (n - 1,) of its new motions; -1 samples for others.

    ``chosen`` is the number of the candidate taken, or -1, for each waypoint of the last sweep or for each try.
    """

    path: Floats
    chosen: Ints
    clearance: Floats
    samples: Ints


def descend(judge: ProofSettings, descent: Descent, begin: Ints | None = None) -> tuple[RefinedPath, int, Step]:
    """Return the path after proven moves of its waypoints, the number of sweeps, and the next step.

    In the first sweep the ``begin`` ((n - 1) // 2,) cheapest candidates of each waypoint are skipped.
    """
    found, sweeps, step = compiled.descend(*judge, *descent, begin)
    return RefinedPath(*found), sweeps, Step(*step)


def even_stretches(judge: ProofSettings, stretches: EvenStretches, begin: int = 0) -> RefinedPath:
    """Return the path after all tries: each takes the most profitable stretch with proven motions.

    The first try skips its ``begin`` best candidates.
    """
    return RefinedPath(*compiled.even_stretches(*judge, *stretches, begin))
