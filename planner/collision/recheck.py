"""Second looks at motions: states along them between which no point moves farther than a step. No proofs.

How far points move is bounded by ``NativeWorld.walk``, part by part, from how bodies turn and slide there.
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

_LONGEST = 0.05  # m that joints alone could move a point on a part, over which its motion is bounded
_AT_ONCE = 16384  # states
_SAME = 1e-12  # rad (m): states nearer to each other are one


@dataclass(frozen=True, eq=False)
class PathContact:
    """A ``contact`` that was seen on a ``piece`` at s in [0, 1], in configuration ``q`` (dof,)."""

    piece: int
    s: float
    q: Floats
    contact: Contact


@dataclass(frozen=True, eq=False)
class PathSamples:
    """Where to look: at ``s`` (n,) on ``piece`` (n,). A pair's distance changes by no more than ``apart`` (pairs,) m
    from one look to the next."""

    piece: Ints
    s: Floats
    apart: Floats


def sample_along(checker: CollisionChecker, coefficients: Floats, step: float) -> PathSamples:
    """Looks at pieces (m, degree + 1, dof), each of which begins where the last one ends; at both ends too."""
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
    """The first contact on pieces (m, degree + 1, dof), one after the other, that is seen every ``step`` (m).

    The second opinion on what is proven. Where a piece begins as the one before it ends, that state is looked at once.
    ``progress`` is called with the number of pieces that have been looked at.
    """
    for rows in _joined(coefficients):
        looks = sample_along(checker, coefficients[rows], step)
        for first in range(0, len(looks.s), _AT_ONCE):
            piece, s = looks.piece[first : first + _AT_ONCE] + rows.start, looks.s[first : first + _AT_ONCE]
            states = CurveStates(coefficients, piece, s)
            found = checker.first_contact_along(states, looks.apart)
            if found is not None:
                k = found[0]
                return PathContact(int(piece[k]), float(s[k]), states[k : k + 1][0], found[1])
            progress(int(piece[-1]) + 1)
    return None


def _joined(coefficients: Floats) -> Iterator[slice]:
    """Rows of pieces of which each begins where the one before it ends."""
    jumps = np.abs(coefficients[1:, 0] - coefficients[:-1].sum(axis=1)).max(axis=1, initial=0.0) > _SAME
    ends = [0, *(np.flatnonzero(jumps) + 1).tolist(), len(coefficients)]
    return (slice(a, b) for a, b in itertools.pairwise(ends) if b > a)


def straight(start: Floats, delta: Floats) -> Floats:
    """Straight motions from ``start`` by ``delta`` (m, dof) as pieces (m, 2, dof)."""
    return np.stack([start, delta], axis=1)


def sample_segment(checker: CollisionChecker, start: Floats, delta: Floats, step: float = 1e-3) -> Contact | None:
    """The first contact that is seen on a segment every ``step`` (m), without bounds or proofs; else None."""
    found = sample_contacts(checker, straight(start[None], delta[None]), step)
    return found.contact if found else None


def states_along(start: Floats, delta: Floats, motion: float, step: float) -> Floats:
    """Configurations along a segment, both ends included, between which no point moves further than ``step`` (m).

    ``motion`` is the most that any point moves on the whole segment.
    """
    count = max(1, int(np.ceil(motion / step)))
    return start + np.linspace(0.0, 1.0, count + 1)[:, None] * delta


def dense_states(world: World, start: Floats, delta: Floats, step: float) -> tuple[Floats, Floats]:
    """Configurations (n, dof) along a segment, no point moving more than ``step`` (m) from one to the next.

    By what joints move at most in any configuration. And by how much (m) the distance of each pair changes at most
    from one to the next, (pairs,).
    """
    states = states_along(start, delta, float(world.reach.motion(delta[None]).max(initial=0.0)), step)
    return states, product(world.pair_reach, world.reach.chain.sizes(delta)) / (len(states) - 1)


class Clearance:
    """Distance (m) of the nearest checked pair that some joint can move, for configurations of one world.

        clearance = Clearance(checker)
        clearance(q)                    # (n,) for q (n, dof); 0 where a pair touches, inf where no pair is checked
        clearance(q, below=0.01)        # the same where it is less, and a lower bound of 0.01 or more elsewhere

    The margin plays no part. Pairs that no joint moves against each other (the base on its table) are left out.
    """

    def __init__(self, checker: CollisionChecker) -> None:
        self._checker = checker
        self._static = ~checker.world.moving

    def __call__(self, q: Floats, below: float = np.inf) -> Floats:
        rotation, position, bounds = self._bounded(np.atleast_2d(q))
        return self._nearest(bounds, rotation, position, below)

    def smallest(self, q: Floats, below: float = np.inf) -> Floats:
        """(n,) the same where it is the smallest of q (n, dof), and less than ``below``; lower bounds elsewhere."""
        rotation, position, bounds = self._bounded(q)
        least = np.maximum(bounds.min(axis=1, initial=np.inf), 0.0)
        for k in np.argsort(least, kind="stable").tolist():
            if least[k] >= below:
                break
            at = slice(k, k + 1)
            least[k] = self._nearest(bounds[at], rotation[:, at], position[:, at], below)[0]
            below = min(below, least[k])
        return least

    def _bounded(self, q: Floats) -> tuple[Floats, Floats, Floats]:
        """The placements of the joints, and cheap lower bounds (n, pairs) on distances."""
        rotation, position = joint_placements(self._checker.chain, q)
        bounds = self._checker.bound.coarse(rotation, position)
        bounds[:, self._static] = np.inf
        return rotation, position, bounds

    def _nearest(self, bounds: Floats, rotation: Floats, position: Floats, below: float) -> Floats:
        """(n,) exact distances in the order of their lower ``bounds`` (n, pairs), until none can beat the best.

        One pair of every configuration at a time, where the next one can.
        """
        best, order = np.full(len(bounds), np.inf), np.argsort(bounds, axis=1, kind="stable")
        for pairs, least in zip(order.T, np.take_along_axis(bounds, order, axis=1).T, strict=True):
            nearest = np.minimum(best, below)
            rows = np.flatnonzero(least < nearest)
            if not len(rows):
                break
            found = self._checker.distances_in(rotation, position, rows, pairs[rows], nearest[rows])
            best[rows] = np.minimum(best[rows], np.maximum(found, 0.0))
        farther = np.where(bounds >= below, bounds, np.inf).min(axis=1, initial=np.inf)
        return np.minimum(best, farther)


def recheck_pieces(
    checker: CollisionChecker,
    coefficients: Floats,
    step: float = RECHECK,
    second: CollisionChecker | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> PathContact | None:
    """The first contact on pieces (m, degree + 1, dof) that one of two libraries sees; None where both see none.

    The ``checker`` samples every ``RECHECK_BY_BACKEND`` (m) of motion, or every ``step`` where that is longer, and
    coal every ``step`` (m). ``second`` takes the place of coal's checker. ``progress`` is called with how many looks at
    a piece by a library are done, and how many there are.
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
