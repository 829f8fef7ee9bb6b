"""Improving moves of a path: only proven alternatives are chosen.

An :class:`planner.collision.edge_prover.EdgeProver` proves them, and may record every chosen motion.
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

_FIELDS_OF_TRY = ("ends", "joints", "shares")
_EXHAUSTED = 2**30  # more alternatives than there are

Ramp = tuple[int, tuple[int, float], tuple[int, float], Floats]
"""Its number among the candidates, piece and s on the curve of both ends, and its pieces (m, 3, dof)."""

Chosen = TypeVar("Chosen")


class _Motions(NamedTuple):
    """Proven straight motions from ``start`` by ``delta`` (m, dof), each for an ``item`` (m,)."""

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
    resolution: float = PROOF,
    allows: MotionTest | None = None,
) -> Ints:
    """Return for each of n items the number (n,) of its first proven alternative, or -1.

    Item k has ``alternatives[k]`` of them; alternative j has ``motions[j]`` of the straight motions from ``start`` by
    ``delta`` (m, dof), in order. An alternative that ``allows`` rejects is not chosen. The proof of an alternative
    stops at its first failure.
    """
    start, delta = as_configurations(prover.checker, "start", start), as_configurations(prover.checker, "delta", delta)
    begin, of = np.zeros(len(alternatives), dtype=np.int64), np.repeat(np.arange(len(alternatives)), alternatives)
    if prover.static_contact is not None:
        return begin - 1
    coefficients, item = np.stack([start, delta], axis=1), np.repeat(of, motions)

    def choose(begin: Ints) -> tuple[Ints, _Motions, Ints]:
        """The first proven ones, as numbers."""
        result, clearance, samples = prover.native.first_proven(
            prover.bounds, coefficients, motions, alternatives, begin, resolution
        )
        rows = samples >= 0
        return result, _Motions(item[rows], start[rows], delta[rows], clearance[rows], samples[rows]), result

    return _choose_allowed(prover, choose, begin, _with_constraints(prover, allows))


def descend(
    prover: EdgeProver, charge: Charge, descent: Descent, resolution: float, allows: MotionTest | None
) -> Floats:
    """Return the path (n, dof) after its waypoints moved downhill by proven, allowed motions.

    All sweeps run in one call if the motions pass the tests that follow; else one by one, and each waypoint takes its
    first allowed position.
    """
    judge, test = ProofSettings(prover.native, prover.bounds, resolution, charge), _with_constraints(prover, allows)
    if prover.static_contact is not None:
        return descent.path
    if test is None and _accept(prover, result := native.descend(judge, descent)[0], None):
        return result.path
    for sweep in range(len(descent.draws)):
        one = descent._replace(first=1 + (descent.first - 1 + sweep) % 2, draws=descent.draws[sweep : sweep + 1])
        path, sweeps, step = _sweep(prover, judge, one, test)
        if not sweeps:
            break
        descent = descent._replace(path=path, step=step)
    return descent.path


def _sweep(
    prover: EdgeProver, judge: ProofSettings, descent: Descent, allows: MotionTest | None
) -> tuple[Floats, int, Step]:
    """Return the path after one sweep of allowed motions, the number of sweeps, and the next step."""
    n = len(descent.path)
    row = np.arange(descent.first, n - 1, 2)

    def choose(begin: Ints) -> tuple[Ints, _Motions, tuple[Floats, int, Step]]:
        """The places of the waypoints, as the path through them."""
        result, sweeps, step = native.descend(judge, descent, begin)
        item = np.flatnonzero(result.chosen[: len(row)] >= 0) if sweeps else row[:0]
        first = (row[item, None] + np.array([-1, 0])).ravel()
        start, delta = result.path[first], result.path[first + 1] - result.path[first]
        motions = _Motions(np.repeat(item, 2), start, delta, result.clearance[first], result.samples[first])
        return result.chosen, motions, (result.path, sweeps, step)

    return _choose_allowed(prover, choose, np.zeros(max(0, (n - 1) // 2), dtype=np.int64), allows)


def straighten(
    prover: EdgeProver, charge: Charge, stretches: EvenStretches, resolution: float, allows: MotionTest | None
) -> Floats:
    """Return the path (n, dof) after some joints move evenly on stretches, by proven, allowed motions.

    As :func:`descend`, with tries in place of sweeps.
    """
    judge, test = ProofSettings(prover.native, prover.bounds, resolution, charge), _with_constraints(prover, allows)
    if prover.static_contact is not None:
        return stretches.path
    if test is None and _accept(prover, result := native.even_stretches(judge, stretches), None):
        return result.path
    for k in range(len(stretches.ends)):
        one, begin = stretches._replace(**{name: getattr(stretches, name)[k : k + 1] for name in _FIELDS_OF_TRY}), 0
        while (result := native.even_stretches(judge, one, begin)).chosen[0] >= 0:
            if _accept(prover, result, test):
                stretches = stretches._replace(path=result.path)
                break
            begin = int(result.chosen[0]) + 1
    return stretches.path


def _accept(prover: EdgeProver, result: RefinedPath, allows: MotionTest | None) -> bool:
    """Return whether all new motions of a path are allowed; record them if so."""
    rows = np.flatnonzero(result.samples >= 0)
    start, delta = result.path[rows], result.path[rows + 1] - result.path[rows]
    allowed = bool(prover.is_allowed(start, delta, allows).all())
    if allowed:
        prover.note(start, delta, result.clearance[rows], result.samples[rows])
    return allowed


def _choose_allowed(
    prover: EdgeProver, choose: Callable[[Ints], tuple[Ints, _Motions, Chosen]], begin: Ints, allows: MotionTest | None
) -> Chosen:
    """Return the first choice at or after ``begin`` (n,) of which every motion is allowed.

    ``choose`` returns the first proven alternative of each of n items (-1 for none), its motions, and the choice.
    """
    while True:
        result, motions, chosen = choose(begin)
        if not len(motions.item):
            return chosen
        allowed = prover.is_allowed(motions.start, motions.delta, allows)
        if allowed.all():
            prover.note(*motions[1:])
            return chosen
        begin = np.where(result < 0, _EXHAUSTED, result)
        begin[motions.item[~allowed]] += 1


def _price_constraints(prover: EdgeProver, points: Floats, price: Floats) -> Floats:
    """Return prices (k, k) with inf for motions that may violate the path constraints."""
    price = price.copy()
    if prover.world.constraints:
        i, j = np.nonzero(np.isfinite(price))
        strays = ~prover.world.constraints.prove(np.stack([points[i], points[j] - points[i]], axis=1))
        price[i[strays], j[strays]] = np.inf
    return price


def cheapest_chain(
    prover: EdgeProver, points: Floats, price: Floats, resolution: float = PROOF, allows: MotionTest | None = None
) -> Ints:
    """Return the rows (r,) of the cheapest chain of proven motions from first to last of ``points``.

    Consecutive ``points`` (k, dof) are connected by proven motions; ``price`` (k, k) is the cost from a row to a later
    one, inf where excluded. Only motions of cheapest chains are proven, up to the first failure. Motions that
    ``allows`` rejects are excluded. Returns all rows if no chain is found.
    """
    points = as_configurations(prover.checker, "points", points)
    if prover.static_contact is not None:
        return np.arange(len(points))
    price = _price_constraints(prover, points, price)
    while True:
        rows, clearance, samples = prover.native.cheapest_chain(prover.bounds, points, price, resolution)
        fresh = samples >= 0
        a, b = rows[:-1][fresh], rows[1:][fresh]
        allowed = prover.is_allowed(points[a], points[b] - points[a], allows)
        if allowed.all():
            prover.note(points[a], points[b] - points[a], clearance[fresh], samples[fresh])
            return rows
        price[a[~allowed], b[~allowed]] = np.inf


def _with_constraints(prover: EdgeProver, allows: MotionTest | None) -> MotionTest | None:
    """Return the caller's test combined with the world's path constraints."""
    constraints = prover.world.constraints
    if not constraints:
        return allows

    def both(start: Floats, delta: Floats) -> Bools:
        kept = constraints.prove(np.stack([start, delta], axis=1))
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
    resolution: float = PROOF,
) -> Ramp | None:
    """Return the first pair of ``moments`` (n, 2) s on a curve that a proven parabolic ramp connects.

    See :func:`planner.native.compiled.curve_next_ramp`.
    """
    tried = 0
    while prover.static_contact is None:
        result = curve_next_ramp(
            prover.native, prover.bounds, resolution, curve, phases, moments[tried:], shares, limits, positions
        )
        if result is None:
            break
        number, start, end, ramp = result
        tried += number + 1
        if prover.keeps_constraints(ramp):
            return tried - 1, start, end, ramp
    return None
