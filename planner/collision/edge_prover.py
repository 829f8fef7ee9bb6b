"""Proofs that joint paths are free between samples: adaptive sampling with clearance (Schwarzer, Saha, Latombe 2005).

Where a pair of bodies is d apart, no motion that moves them against each other by less than d can make them touch.
A joint's motion dq moves no point further than its distance from the joint's axis times |dq|, so every sample clears an
interval of the path; when the intervals of every pair cover it, the path is proven, for all the configurations on it
and not just for those that were sampled. The loop is compiled: ``native/source/prover.hpp``.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import NamedTuple, TypeVar

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, numbers, plain_numbers
from planner.base.errors import ArrayError
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker, configurations
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.native.compiled import Charge, curve_next_ramp
from planner.native.refinement import Descent, EvenStretches, Judge, Refined, Step, descend, even_stretches

_BATCH = 256  # pieces between two looks whether to stop
_OF_A_TRY = ("ends", "joints", "shares")
_NONE_LEFT = 2**30  # more alternatives than there are

Ramp = tuple[int, tuple[int, float], tuple[int, float], Floats]
"""Its number among those tried, a piece of the curve and s on it for both ends, and its pieces (m, 3, dof)."""

MotionTest = Callable[[Floats, Floats], Bools]
"""Which motions from configurations (m, dof) by joint motions (m, dof) may be taken, (m,)."""


MotionCheck = Callable[[Floats, Floats], bool]
"""Whether the straight motion from a configuration (dof,) by a difference (dof,) is taken for free."""


Chosen = TypeVar("Chosen")


class Verdict(IntEnum):
    """What is known about a segment."""

    FREE = 0  # proven
    COLLIDES = 1  # a configuration on it touches, or comes closer than the margin
    UNDECIDED = 2  # it passes closer than the resolution: neither proven nor refuted


_LARGEST = 100.0 * FARTHEST  # rad (m): coefficients of curves may be larger than what they add up to
_FREE = int(Verdict.FREE)  # NumPy takes several times as long to compare with a member


@dataclass(frozen=True, eq=False)
class Proofs:
    """The verdicts on a batch of segments, and the samples they needed."""

    verdict: Ints  # (m,) of Verdict
    pair: Ints  # (m,) the pair that stopped a segment, -1 where it is free
    samples: Ints  # (m,) configurations sampled
    # (m,) m, a lower bound on the distance beyond the margin along a free segment, of the pairs that a joint can move
    clearance: Floats

    @property
    def free(self) -> Bools:
        return self.verdict == _FREE

    def and_then(self, more: Proofs) -> Proofs:
        """These segments, then ``more``."""
        both = ((getattr(self, one.name), getattr(more, one.name)) for one in fields(self))
        return Proofs(*(np.concatenate(pair) for pair in both))

    @staticmethod
    def alike(count: int, verdict: Verdict) -> Proofs:
        """``count`` segments of one verdict, of which nothing else is known."""
        nothing = np.zeros(count, dtype=np.int64)
        return Proofs(nothing + int(verdict), nothing - 1, nothing, np.full(count, np.inf))


class _Motions(NamedTuple):
    """Straight motions from ``start`` by ``delta`` (m, dof) that are proven, and the ``item`` (m,) that each serves."""

    item: Ints
    start: Floats
    delta: Floats
    clearance: Floats
    samples: Ints


class EdgeProver:
    """Proves motions in one world with one exact checker; one implementation whatever the backend.

        prover = EdgeProver(checker)
        prover.free(a, robot.difference(a, b))               # (m,) True where proven; straight ones, (m, dof) each
        prover.prove(a, robot.difference(a, b)).pair         # (m,) what stopped the others

    Planes between the shapes prove; the checker says what touches where they cannot. A motion that is not decided is
    ``Verdict.UNDECIDED``: never treat that as free. Once ``progress`` is asked to stop, everything that is still open
    is undecided. What the world's motions keep (:class:`planner.constraints.keeps.Keeps`) is proven of all that is
    called free; what is not proven to keep it is undecided, with no pair. So is a motion on which a slide leaves what
    its limits allow, as reaches hold no farther; limits of other joints are not looked at. :class:`PlannerError` for
    arrays of other shapes, or with what is no finite number.
    """

    def __init__(self, checker: CollisionChecker, progress: Progress = QUIET) -> None:
        self.checker, self.progress = checker, progress
        self.world: World = checker.world
        self.robot = checker.robot
        self._native, self._bounds = checker.bound.native, checker.bound.of_all
        self.static_contact = checker.static_contact

    def only(self, pairs: Bools) -> EdgeProver:
        """A prover of these ``pairs`` (pairs,) alone: what it calls free may touch in others."""
        left_out = self._bounds.left_out
        if np.shape(pairs) != left_out.shape:
            raise ArrayError(f"pairs has shape {np.shape(pairs)}: give one truth value for each of {left_out.size}.")
        part = copy.copy(self)
        part._bounds = self._native.bounds(self.world.pair_reach, self.world.reach.bodies, left_out | ~pairs)
        return part

    def _touching(self, rotation: Floats, position: Floats, pairs: Ints) -> int | None:
        """The first of ``pairs`` that the checker finds within the margin at one placement of the joints."""
        gaps = self.checker.distances(rotation, position, pairs) if len(pairs) else np.zeros(0)
        touching = pairs[gaps <= self.world.margin]
        return int(touching[0]) if len(touching) else None

    def prove(self, start: Floats, delta: Floats, room: float = PROOF, contacts: bool = True) -> Proofs:
        """Verdicts on the segments start + s delta, s in [0, 1]; arrays (m, dof).

        A segment is undecided where a sample has less than ``room`` (m) of clearance beyond the margin. A smaller
        ``room`` proves more of the tight segments, and takes longer on each of them. Without ``contacts`` all that are
        not free are undecided: nobody asks the checker whether they collide, which takes as long as the proofs.
        """
        start, delta = np.atleast_2d(plain_numbers("start", start)), np.atleast_2d(plain_numbers("delta", delta))
        if start.shape != delta.shape:
            raise ArrayError(f"start has shape {start.shape} and delta {delta.shape}: give as many motions as starts.")
        return self.prove_curves(np.stack([start, delta], axis=1), room, contacts)

    def free(self, start: Floats, delta: Floats, room: float = PROOF) -> Bools:
        """(m,) which segments are proven, as :meth:`prove` has it without asking what the others touch."""
        return self.prove(start, delta, room, contacts=False).free

    def each_free(self, room: float = PROOF) -> MotionCheck:
        """As :meth:`free`, of one motion after the other, from a configuration (dof,) by a difference (dof,).

        One thread asks it.
        """
        prove, keeps, inside = self._native.prove_motion, self.world.keeps, self.checker.inside

        def free(first: Floats, delta: Floats) -> bool:
            """Whether one motion is proven, and what is kept by it too."""
            found = (
                None
                if self.static_contact is not None or self.progress.stopped
                else prove(self._bounds, first, delta, room)
            )
            if found is None or inside.pairs(first[None])[0] >= 0:
                return False
            if keeps and not keeps.proven(np.stack([first, delta])[None])[0]:
                return False
            self._note(first[None], delta[None], np.array(found[:1]), np.array(found[1:]))
            return True

        return free

    def first_free(
        self,
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
        start, delta = configurations(self.checker, "start", start), configurations(self.checker, "delta", delta)
        begin, of = np.zeros(len(alternatives), dtype=np.int64), np.repeat(np.arange(len(alternatives)), alternatives)
        if self.static_contact is not None:
            return begin - 1
        coefficients, item = np.stack([start, delta], axis=1), np.repeat(of, motions)

        def choose(begin: Ints) -> tuple[Ints, _Motions, Ints]:
            """The first proven ones, as numbers."""
            found, clearance, samples = self._native.first_proven(
                self._bounds, coefficients, motions, alternatives, begin, room
            )
            rows = samples >= 0
            return found, _Motions(item[rows], start[rows], delta[rows], clearance[rows], samples[rows]), found

        return self._first_allowed(choose, begin, self._keeping(allows))

    def descend(self, charge: Charge, descent: Descent, room: float, allows: MotionTest | None) -> Floats:
        """The path (n, dof) after its waypoints moved downhill by proven motions that pass a test of the caller.

        All sweeps are made at once where motions rarely fail what is not proven with them; else one by one, in which
        each waypoint goes to the first of its places that is allowed.
        """
        judge, keeping = Judge(self._native, self._bounds, room, charge), self._keeping(allows)
        if self.static_contact is not None:
            return descent.path
        if keeping is None and self._takes(found := descend(judge, descent)[0], None):
            return found.path
        for sweep in range(len(descent.draws)):
            one = descent._replace(first=1 + (descent.first - 1 + sweep) % 2, draws=descent.draws[sweep : sweep + 1])
            path, sweeps, step = self._swept(judge, one, keeping)
            if not sweeps:
                break
            descent = descent._replace(path=path, step=step)
        return descent.path

    def _swept(self, judge: Judge, descent: Descent, allows: MotionTest | None) -> tuple[Floats, int, Step]:
        """The path after one sweep of a descent, all of whose motions are allowed, and what else the sweep says."""
        n = len(descent.path)
        row = np.arange(descent.first, n - 1, 2)

        def choose(begin: Ints) -> tuple[Ints, _Motions, tuple[Floats, int, Step]]:
            """The places of the waypoints, as the path through them."""
            found, sweeps, step = descend(judge, descent, begin)
            item = np.flatnonzero(found.chosen[: len(row)] >= 0) if sweeps else row[:0]
            first = (row[item, None] + np.array([-1, 0])).ravel()
            start, delta = found.path[first], found.path[first + 1] - found.path[first]
            motions = _Motions(np.repeat(item, 2), start, delta, found.clearance[first], found.samples[first])
            return found.chosen, motions, (found.path, sweeps, step)

        return self._first_allowed(choose, np.zeros(max(0, (n - 1) // 2), dtype=np.int64), allows)

    def straighten(self, charge: Charge, stretches: EvenStretches, room: float, allows: MotionTest | None) -> Floats:
        """The path (n, dof) after some joints move evenly on stretches of it, by proven motions that pass a test.

        As :meth:`descend`, with tries in place of sweeps.
        """
        judge, keeping = Judge(self._native, self._bounds, room, charge), self._keeping(allows)
        if self.static_contact is not None:
            return stretches.path
        if keeping is None and self._takes(found := even_stretches(judge, stretches), None):
            return found.path
        for k in range(len(stretches.ends)):
            one, begin = stretches._replace(**{name: getattr(stretches, name)[k : k + 1] for name in _OF_A_TRY}), 0
            while (found := even_stretches(judge, one, begin)).chosen[0] >= 0:
                if self._takes(found, keeping):
                    stretches = stretches._replace(path=found.path)
                    break
                begin = int(found.chosen[0]) + 1
        return stretches.path

    def _takes(self, found: Refined, allows: MotionTest | None) -> bool:
        """Whether all motions that are new in a path are allowed; then they are noted."""
        rows = np.flatnonzero(found.samples >= 0)
        start, delta = found.path[rows], found.path[rows + 1] - found.path[rows]
        allowed = bool(self._allowed(start, delta, allows).all())
        if allowed:
            self._note(start, delta, found.clearance[rows], found.samples[rows])
        return allowed

    def _first_allowed(
        self, choose: Callable[[Ints], tuple[Ints, _Motions, Chosen]], begin: Ints, allows: MotionTest | None
    ) -> Chosen:
        """What is chosen of alternatives from ``begin`` (n,) on, once everything about it is allowed.

        ``choose`` says which is the first proven one of each of n items, -1 for none, and of what motions they consist.
        """
        while True:
            found, motions, chosen = choose(begin)
            if not len(motions.item):
                return chosen
            allowed = self._allowed(motions.start, motions.delta, allows)
            if allowed.all():
                self._note(*motions[1:])
                return chosen
            begin = np.where(found < 0, _NONE_LEFT, found)
            begin[motions.item[~allowed]] += 1

    def _of_kept(self, points: Floats, price: Floats) -> Floats:
        """The prices (k, k) of motions between ``points`` (k, dof), infinite for those that may stray."""
        price = price.copy()
        if self.world.keeps:
            i, j = np.nonzero(np.isfinite(price))
            strays = ~self.world.keeps.proven(np.stack([points[i], points[j] - points[i]], axis=1))
            price[i[strays], j[strays]] = np.inf
        return price

    def cheapest_chain(
        self, points: Floats, price: Floats, room: float = PROOF, allows: MotionTest | None = None
    ) -> Ints:
        """The rows (r,) of the cheapest chain of proven straight motions from the first of ``points`` to the last one.

        ``points`` (k, dof), of which consecutive ones are joined by proven motions; ``price`` (k, k) of motions, from
        a row to a later one, infinite for those that may not be taken. Only motions of cheapest chains are proven, no
        further than until one of a chain is refused. What ``allows`` refuses is no part of a chain either. All rows
        where there is none.
        """
        points = configurations(self.checker, "points", points)
        if self.static_contact is not None:
            return np.arange(len(points))
        price = self._of_kept(points, price)
        while True:
            rows, clearance, samples = self._native.cheapest_chain(self._bounds, points, price, room)
            fresh = samples >= 0
            a, b = rows[:-1][fresh], rows[1:][fresh]
            allowed = self._allowed(points[a], points[b] - points[a], allows)
            if allowed.all():
                self._note(points[a], points[b] - points[a], clearance[fresh], samples[fresh])
                return rows
            price[a[~allowed], b[~allowed]] = np.inf

    def _allowed(self, start: Floats, delta: Floats, allows: MotionTest | None) -> Bools:
        """(m,) which motions without a crossed surface have no body inside another, and pass a test of the caller."""
        allowed = self.checker.inside.pairs(start) < 0
        return allowed if allows is None else allowed & allows(start, delta)

    def _keeping(self, allows: MotionTest | None) -> MotionTest | None:
        """A test of the caller's, and whether motions keep what they have to keep in this world."""
        keeps = self.world.keeps
        if not keeps:
            return allows

        def both(start: Floats, delta: Floats) -> Bools:
            kept = keeps.proven(np.stack([start, delta], axis=1))
            return kept if allows is None else kept & allows(start, delta)

        return both

    def _note(self, start: Floats, delta: Floats, clearance: Floats, samples: Ints) -> None:
        """What was found of the free motions from ``start`` by ``delta`` (m, dof); nothing is kept."""

    def note_pieces(self, path: Floats, rows: Floats, parts: Ints) -> None:
        """That ``rows`` (k, dof) cut the proven motions of a ``path`` (m + 1, dof) into ``parts`` (m,); not kept."""

    def prove_curves(self, coefficients: Floats, room: float = PROOF, contacts: bool = True) -> Proofs:
        """Verdicts on polynomial pieces q(s) = sum_k c_k s^k, s in [0, 1]; ``coefficients`` (m, degree + 1, dof).

        As :meth:`prove`, with the largest |q'| on an interval in place of |delta|, bounded by Bernstein coefficients.
        Joint limits are not looked at, but for those of slides.
        """
        coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", self.robot.dof), most=_LARGEST)
        if self.static_contact is not None:
            return Proofs.alike(len(coefficients), Verdict.COLLIDES)
        kept = self.world.keeps.proven(coefficients)
        if kept.all():
            return self._proven_free(coefficients, room, contacts)
        rows = np.arange(len(kept)) if contacts else np.flatnonzero(kept)  # what strays is asked for contacts only
        proofs = Proofs.alike(len(kept), Verdict.UNDECIDED)
        found = self._proven_free(coefficients[rows], room, contacts)
        for one in fields(found):
            getattr(proofs, one.name)[rows] = getattr(found, one.name)
        proofs.verdict[~kept & proofs.free] = Verdict.UNDECIDED
        return proofs

    def _proven_free(self, coefficients: Floats, room: float, contacts: bool) -> Proofs:
        """As :meth:`prove_curves`, whatever motions keep besides."""
        proofs, where = self._prove_batch(coefficients[:_BATCH], room)
        for first in range(_BATCH, len(coefficients), _BATCH):
            if self.progress.stopped:
                proofs = proofs.and_then(Proofs.alike(len(coefficients) - first, Verdict.UNDECIDED))
                break
            more, there = self._prove_batch(coefficients[first : first + _BATCH], room)
            proofs, where = proofs.and_then(more), np.append(where, there)
        if contacts:
            self._find_contacts(proofs, coefficients, where)
        free = np.flatnonzero(proofs.free)
        self._find_inside(proofs, coefficients[free, 0], free)
        return proofs

    def all_free(self, coefficients: Floats, room: float = PROOF) -> bool:
        """Whether all polynomial pieces (m, degree + 1, dof) are proven, as :meth:`prove_curves` has it.

        No more is proven once a piece is refused. Where each lies near the ones before and behind it, that is found in
        half of the time.
        """
        coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", self.robot.dof), most=_LARGEST)
        if self.static_contact is not None:
            return False
        for first in range(0, len(coefficients), _BATCH):
            batch = coefficients[first : first + _BATCH]
            if self.progress.stopped or self._native.prove_together(self._bounds, batch, room)[0].any():
                return False
        return self._kept(coefficients)

    def next_ramp(
        self,
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
        while self.static_contact is None:
            found = curve_next_ramp(
                self._native, self._bounds, room, curve, phases, moments[tried:], shares, limits, positions
            )
            if found is None:
                break
            number, start, end, ramp = found
            tried += number + 1
            if self._kept(ramp):
                return tried - 1, start, end, ramp
        return None

    def _kept(self, coefficients: Floats) -> bool:
        """Of pieces that cross no surface, whether none begins inside something, and all keep what motions keep."""
        if (self.checker.inside.pairs(coefficients[:, 0]) >= 0).any():
            return False
        return bool(self.world.keeps.proven(coefficients).all())

    def _prove_batch(self, coefficients: Floats, room: float) -> tuple[Proofs, Floats]:
        """The proofs, and where those stopped that are undecided."""
        verdict, pair, samples, clearance, where = self._native.prove(self._bounds, coefficients, room)
        return Proofs(verdict, pair, samples, clearance), where

    def _find_contacts(self, proofs: Proofs, coefficients: Floats, where: Floats) -> None:
        """Which undecided pieces collide where their proofs stopped, by the checker."""
        stopped = np.flatnonzero(proofs.pair >= 0)
        if not len(stopped):
            return
        powers = where[stopped, None] ** np.arange(coefficients.shape[1])
        q = np.einsum("mk,mkd->md", powers, coefficients[stopped])
        rotation, position = joint_placements(self.checker.chain, q)
        for k, row in enumerate(stopped):
            pair = proofs.pair[row : row + 1]
            if self._touching(rotation[:, k], position[:, k], pair) is not None:
                proofs.verdict[row] = Verdict.COLLIDES
        self._find_inside(proofs, q, stopped)

    def _find_inside(self, proofs: Proofs, states: Floats, rows: Ints) -> None:
        """Which of the pieces ``rows`` (k,) have a body inside another at the state (dof,) of each that is given.

        Where no surface is crossed, what is inside at the beginning is so throughout.
        """
        inside = self.checker.inside.pairs(states)
        proofs.verdict[rows[inside >= 0]] = Verdict.COLLIDES
        proofs.pair[rows[inside >= 0]] = inside[inside >= 0]
