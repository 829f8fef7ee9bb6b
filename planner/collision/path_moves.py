"""Moves that make a path better, chosen among alternatives of which only the proven ones count.

Each takes an :class:`planner.collision.edge_prover.EdgeProver`, which proves them, and may record every motion
that is chosen.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.resolutions import PROOF
from planner.collision.checker import as_configurations
from planner.collision.edge_prover import EdgeProver, MotionTest
from planner.native import refinement as native
from planner.native.compiled import Charge, curve_next_ramp
from planner.native.refinement import Descent, EvenStretches, ProofSettings, RefinedPath, Step

_OF_A_TRY = ("ends", "joints", "shares")
_NONE_LEFT = 2**30  # more alternatives than there are

Ramp = tuple[int, tuple[int, float], tuple[int, float], Floats]
"""Its number among those tried, a piece of the curve and s on it for both ends, and its pieces (m, 3, dof)."""

Chosen = TypeVar("Chosen")


class _Motions(NamedTuple):
    """Straight motions from ``start`` by ``delta`` (m, dof) that are proven, and the ``item`` (m,) that each serves."""

    item: Ints
    start: Floats
    delta: Floats
    clearance: Floats
    samples: Ints


def first_free(
    prover: EdgeProver,
    start: Floats,
    delta: Floats,
    motions: Ints,
    alternatives: Ints,
    room: float = PROOF,
    allows: MotionTest | None = None,
) -> Ints:
    """For each of n items the number (n,) of the first of its alternatives whose motions are all proven, or -1.

    Item k has ``alternatives[k]`` of them, alternative j consists of ``motions[j]`` of the straight motions from
    ``start`` by ``delta`` (m, dof), one after the other. What ``allows`` refuses is not chosen either. A proof goes
    no further once another motion of its alternative is refused.
    """
    start, delta = as_configurations(prover.checker, "start", start), as_configurations(prover.checker, "delta", delta)
    begin, of = np.zeros(len(alternatives), dtype=np.int64), np.repeat(np.arange(len(alternatives)), alternatives)
    if prover.static_contact is not None:
        return begin - 1
    coefficients, item = np.stack([start, delta], axis=1), np.repeat(of, motions)

    def choose(begin: Ints) -> tuple[Ints, _Motions, Ints]:
        """The first proven ones, as numbers."""
        found, clearance, samples = prover.native.first_proven(
            prover.bounds, coefficients, motions, alternatives, begin, room
        )
        rows = samples >= 0
        return found, _Motions(item[rows], start[rows], delta[rows], clearance[rows], samples[rows]), found

    return _first_allowed(prover, choose, begin, _keeping(prover, allows))


def descend(prover: EdgeProver, charge: Charge, descent: Descent, room: float, allows: MotionTest | None) -> Floats:
    """The path (n, dof) after its waypoints moved downhill by proven motions that pass a test of the caller.

    All sweeps are made at once where motions rarely fail what is not proven with them; else one by one, in which
    each waypoint goes to the first of its places that is allowed.
    """
    judge, keeping = ProofSettings(prover.native, prover.bounds, room, charge), _keeping(prover, allows)
    if prover.static_contact is not None:
        return descent.path
    if keeping is None and _takes(prover, found := native.descend(judge, descent)[0], None):
        return found.path
    for sweep in range(len(descent.draws)):
        one = descent._replace(first=1 + (descent.first - 1 + sweep) % 2, draws=descent.draws[sweep : sweep + 1])
        path, sweeps, step = _sweep(prover, judge, one, keeping)
        if not sweeps:
            break
        descent = descent._replace(path=path, step=step)
    return descent.path


def _sweep(
    prover: EdgeProver, judge: ProofSettings, descent: Descent, allows: MotionTest | None
) -> tuple[Floats, int, Step]:
    """The path after one sweep of a descent, all of whose motions are allowed, and what else the sweep says."""
    n = len(descent.path)
    row = np.arange(descent.first, n - 1, 2)

    def choose(begin: Ints) -> tuple[Ints, _Motions, tuple[Floats, int, Step]]:
        """The places of the waypoints, as the path through them."""
        found, sweeps, step = native.descend(judge, descent, begin)
        item = np.flatnonzero(found.chosen[: len(row)] >= 0) if sweeps else row[:0]
        first = (row[item, None] + np.array([-1, 0])).ravel()
        start, delta = found.path[first], found.path[first + 1] - found.path[first]
        motions = _Motions(np.repeat(item, 2), start, delta, found.clearance[first], found.samples[first])
        return found.chosen, motions, (found.path, sweeps, step)

    return _first_allowed(prover, choose, np.zeros(max(0, (n - 1) // 2), dtype=np.int64), allows)


def straighten(
    prover: EdgeProver, charge: Charge, stretches: EvenStretches, room: float, allows: MotionTest | None
) -> Floats:
    """The path (n, dof) after some joints move evenly on stretches of it, by proven motions that pass a test.

    As :meth:`descend`, with tries in place of sweeps.
    """
    judge, keeping = ProofSettings(prover.native, prover.bounds, room, charge), _keeping(prover, allows)
    if prover.static_contact is not None:
        return stretches.path
    if keeping is None and _takes(prover, found := native.even_stretches(judge, stretches), None):
        return found.path
    for k in range(len(stretches.ends)):
        one, begin = stretches._replace(**{name: getattr(stretches, name)[k : k + 1] for name in _OF_A_TRY}), 0
        while (found := native.even_stretches(judge, one, begin)).chosen[0] >= 0:
            if _takes(prover, found, keeping):
                stretches = stretches._replace(path=found.path)
                break
            begin = int(found.chosen[0]) + 1
    return stretches.path


def _takes(prover: EdgeProver, found: RefinedPath, allows: MotionTest | None) -> bool:
    """Whether all motions that are new in a path are allowed; then they are noted."""
    rows = np.flatnonzero(found.samples >= 0)
    start, delta = found.path[rows], found.path[rows + 1] - found.path[rows]
    allowed = bool(prover.allowed(start, delta, allows).all())
    if allowed:
        prover.note(start, delta, found.clearance[rows], found.samples[rows])
    return allowed


def _first_allowed(
    prover: EdgeProver, choose: Callable[[Ints], tuple[Ints, _Motions, Chosen]], begin: Ints, allows: MotionTest | None
) -> Chosen:
    """What is chosen of alternatives from ``begin`` (n,) on, once everything about it is allowed.

    ``choose`` says which is the first proven one of each of n items, -1 for none, and of what motions they consist.
    """
    while True:
        found, motions, chosen = choose(begin)
        if not len(motions.item):
            return chosen
        allowed = prover.allowed(motions.start, motions.delta, allows)
        if allowed.all():
            prover.note(*motions[1:])
            return chosen
        begin = np.where(found < 0, _NONE_LEFT, found)
        begin[motions.item[~allowed]] += 1


def _of_kept(prover: EdgeProver, points: Floats, price: Floats) -> Floats:
    """The prices (k, k) of motions between ``points`` (k, dof), infinite for those that may stray."""
    price = price.copy()
    if prover.world.constraints:
        i, j = np.nonzero(np.isfinite(price))
        strays = ~prover.world.constraints.proven(np.stack([points[i], points[j] - points[i]], axis=1))
        price[i[strays], j[strays]] = np.inf
    return price


def cheapest_chain(
    prover: EdgeProver, points: Floats, price: Floats, room: float = PROOF, allows: MotionTest | None = None
) -> Ints:
    """The rows (r,) of the cheapest chain of proven straight motions from the first of ``points`` to the last one.

    ``points`` (k, dof), of which consecutive ones are joined by proven motions; ``price`` (k, k) of motions, from
    a row to a later one, infinite for those that may not be taken. Only motions of cheapest chains are proven, no
    further than until one of a chain is refused. What ``allows`` refuses is no part of a chain either. All rows
    where there is none.
    """
    points = as_configurations(prover.checker, "points", points)
    if prover.static_contact is not None:
        return np.arange(len(points))
    price = _of_kept(prover, points, price)
    while True:
        rows, clearance, samples = prover.native.cheapest_chain(prover.bounds, points, price, room)
        fresh = samples >= 0
        a, b = rows[:-1][fresh], rows[1:][fresh]
        allowed = prover.allowed(points[a], points[b] - points[a], allows)
        if allowed.all():
            prover.note(points[a], points[b] - points[a], clearance[fresh], samples[fresh])
            return rows
        price[a[~allowed], b[~allowed]] = np.inf


def _keeping(prover: EdgeProver, allows: MotionTest | None) -> MotionTest | None:
    """A test of the caller's, and whether motions keep what they have to keep in this world."""
    constraints = prover.world.constraints
    if not constraints:
        return allows

    def both(start: Floats, delta: Floats) -> Bools:
        kept = constraints.proven(np.stack([start, delta], axis=1))
        return kept if allows is None else kept & allows(start, delta)

    return both


def next_ramp(
    prover: EdgeProver,
    curve: Floats,
    phases: Floats,
    moments: Floats,
    shares: Floats,
    limits: tuple[Floats, Floats],
    positions: tuple[Floats, Floats],
    room: float = PROOF,
) -> Ramp | None:
    """The first of pairs of ``moments`` (n, 2) s of a motion along a curve that a proven parabolic ramp joins.

    See :func:`planner.native.compiled.curve_next_ramp`.
    """
    tried = 0
    while prover.static_contact is None:
        found = curve_next_ramp(
            prover.native, prover.bounds, room, curve, phases, moments[tried:], shares, limits, positions
        )
        if found is None:
            break
        number, start, end, ramp = found
        tried += number + 1
        if prover.kept(ramp):
            return tried - 1, start, end, ramp
    return None
