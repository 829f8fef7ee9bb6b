"""Independent checks of motions by dense sampling; not proofs.

``NativeWorld.walk`` bounds the motion of points between samples.
"""

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints, cumulative_sums, product
from planner.base.resolutions import RECHECK, RECHECK_BY_BACKEND
from planner.collision import second_checker
from planner.collision.checker import CollisionChecker, CurveStates
from planner.collision.world import Contact, World
from planner.kinematics.forward import joint_placements

_LONGEST = 0.05  # m: joint motion per interval on which the motion of points is bounded
_AT_ONCE = 16384  # states
_SAME = 1e-12  # rad (m): closer states are equal


@dataclass(frozen=True, eq=False)
class PathContact:
    """A ``contact`` at s in [0, 1] on a ``piece``, in configuration ``q`` (dof,)."""

    piece: int
    s: float
    q: Floats
    contact: Contact


@dataclass(frozen=True, eq=False)
class PathSamples:
    """Samples at ``s`` (n,) on ``piece`` (n,); ``apart`` (pairs,) m bounds a pair's change between them."""

    piece: Ints
    s: Floats
    apart: Floats


def sample_along(checker: CollisionChecker, coefficients: Floats, step: float) -> PathSamples:
    """Return samples at most ``step`` (m) apart on contiguous curves (m, degree + 1, dof), with both ends."""
    bound = checker.bound
    parts, moved, shares = bound.native.walk(bound.motion_bounds, coefficients, _LONGEST)
    walked = cumulative_sums(moved)
    count = max(1, math.ceil(walked[-1] / step))
    at = walked[-1] * np.arange(count + 1) / count
    part = np.clip(np.searchsorted(walked, at, side="right") - 1, 0, len(moved) - 1)
    on_part = np.clip((at - walked[part]) / np.where(moved > 0, moved, 1.0)[part], 0.0, 1.0)
    piece = np.repeat(np.arange(len(parts)), parts)[part]
    s = (part - cumulative_sums(parts)[piece] + on_part) / parts[piece]
    piece[-1], s[-1] = len(parts) - 1, 1.0
    return PathSamples(piece, s, shares * walked[-1] / count)


def sample_contacts(
    checker: CollisionChecker, coefficients: Floats, step: float, progress: Callable[[int], None] = lambda done: None
) -> PathContact | None:
    """Return the first contact on curves (m, degree + 1, dof) sampled every ``step`` (m), or None.

    A state where one curve ends and the next begins is checked once. ``progress`` receives the number of curves done.
    """
    for rows in _contiguous_slices(coefficients):
        samples = sample_along(checker, coefficients[rows], step)
        for first in range(0, len(samples.s), _AT_ONCE):
            piece, s = samples.piece[first : first + _AT_ONCE] + rows.start, samples.s[first : first + _AT_ONCE]
            states = CurveStates(coefficients, piece, s)
            result = checker.first_contact_along(states, samples.apart)
            if result is not None:
                k = result[0]
                return PathContact(int(piece[k]), float(s[k]), states[k : k + 1][0], result[1])
            progress(int(piece[-1]) + 1)
    return None


def _contiguous_slices(coefficients: Floats) -> Iterator[slice]:
    """Return slices of curves that each begin where the previous one ends."""
    jumps = np.abs(coefficients[1:, 0] - coefficients[:-1].sum(axis=1)).max(axis=1, initial=0.0) > _SAME
    ends = [0, *(np.flatnonzero(jumps) + 1).tolist(), len(coefficients)]
    return (slice(a, b) for a, b in itertools.pairwise(ends) if b > a)


def straight(start: Floats, delta: Floats) -> Floats:
    """Return straight motions from ``start`` by ``delta`` (m, dof) as curves (m, 2, dof)."""
    return np.stack([start, delta], axis=1)


def sample_segment(checker: CollisionChecker, start: Floats, delta: Floats, step: float = 1e-3) -> Contact | None:
    """Return the first contact on a segment sampled every ``step`` (m), or None."""
    result = sample_contacts(checker, straight(start[None], delta[None]), step)
    return result.contact if result else None


def states_along(start: Floats, delta: Floats, motion: float, step: float) -> Floats:
    """Return states on a segment, both ends included, at most ``step`` (m) apart.

    ``motion`` (m) bounds the motion of any point on the whole segment.
    """
    count = max(1, int(np.ceil(motion / step)))
    return start + np.linspace(0.0, 1.0, count + 1)[:, None] * delta


def dense_states(world: World, start: Floats, delta: Floats, step: float) -> tuple[Floats, Floats]:
    """Return states (n, dof) on a segment, at most ``step`` (m) apart, and each pair's change (pairs,) m."""
    states = states_along(start, delta, float(world.reach.motion(delta[None]).max(initial=0.0)), step)
    return states, product(world.pair_reach, world.reach.chain.sizes(delta)) / (len(states) - 1)


class Clearance:
    """Distance (m) of the nearest pair that joints move against each other, in one world.

        clearance = Clearance(checker)
        clearance(q)                    # (n,) for q (n, dof); 0 in contact, inf without checked pairs
        clearance(q, below=0.01)        # exact below 0.01, a lower bound of at least 0.01 elsewhere

    The margin is not subtracted.
    """

    def __init__(self, checker: CollisionChecker) -> None:
        self._checker = checker
        self._static = ~checker.world.moving

    def __call__(self, q: Floats, below: float = np.inf) -> Floats:
        rotation, position, bounds = self._place_and_bound(np.atleast_2d(q))
        return self._nearest_distances(bounds, rotation, position, below)

    def smallest(self, q: Floats, below: float = np.inf) -> Floats:
        """Return clearances (n,) that are exact at the smallest one, if below ``below``; else lower bounds."""
        rotation, position, bounds = self._place_and_bound(q)
        least = np.maximum(bounds.min(axis=1, initial=np.inf), 0.0)
        for k in np.argsort(least, kind="stable").tolist():
            if least[k] >= below:
                break
            at = slice(k, k + 1)
            least[k] = self._nearest_distances(bounds[at], rotation[:, at], position[:, at], below)[0]
            below = min(below, least[k])
        return least

    def _place_and_bound(self, q: Floats) -> tuple[Floats, Floats, Floats]:
        """Return placements of the joints, and coarse lower bounds (n, pairs)."""
        rotation, position = joint_placements(self._checker.chain, q)
        bounds = self._checker.bound.coarse(rotation, position)
        bounds[:, self._static] = np.inf
        return rotation, position, bounds

    def _nearest_distances(self, bounds: Floats, rotation: Floats, position: Floats, below: float) -> Floats:
        """Return exact clearances (n,); pairs are tried in the order of their ``bounds`` (n, pairs)."""
        best, order = np.full(len(bounds), np.inf), np.argsort(bounds, axis=1, kind="stable")
        for pairs, least in zip(order.T, np.take_along_axis(bounds, order, axis=1).T, strict=True):
            nearest = np.minimum(best, below)
            rows = np.flatnonzero(least < nearest)
            if not len(rows):
                break
            result = self._checker.distances_in(rotation, position, rows, pairs[rows], nearest[rows])
            best[rows] = np.minimum(best[rows], np.maximum(result, 0.0))
        farther = np.where(bounds >= below, bounds, np.inf).min(axis=1, initial=np.inf)
        return np.minimum(best, farther)


def recheck_pieces(
    checker: CollisionChecker,
    coefficients: Floats,
    step: float = RECHECK,
    second: CollisionChecker | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> PathContact | None:
    """Return the first contact on curves (m, degree + 1, dof) that either library finds, or None.

    ``checker`` samples every ``RECHECK_BY_BACKEND`` (m), or every ``step`` if larger; coal, or ``second`` in its place,
    samples every ``step`` (m). ``progress`` receives the curves done and the total, over both.
    """
    judges = dict([(checker, max(step, RECHECK_BY_BACKEND)), (second or second_checker(checker), step)])
    first, count, total = None, len(coefficients), len(judges) * len(coefficients)
    for number, (judge, apart) in enumerate(judges.items()):
        progress(number * count, total)
        before = coefficients if first is None else coefficients[: first.piece + 1]
        seen = sample_contacts(judge, before, apart, lambda done, number=number: progress(number * count + done, total))
        if seen is not None and (first is None or (seen.piece, seen.s) < (first.piece, first.s)):
            first = seen
    progress(total, total)
    return first
