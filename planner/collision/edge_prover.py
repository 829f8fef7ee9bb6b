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

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, numbers, plain_numbers
from planner.base.errors import ArrayError
from planner.base.polynomials import evaluate
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker
from planner.collision.world import World
from planner.kinematics.forward import joint_placements

_BATCH = 256  # pieces between two looks whether to stop

MotionTest = Callable[[Floats, Floats], Bools]
"""Which motions from configurations (m, dof) by joint motions (m, dof) may be taken, (m,)."""


MotionCheck = Callable[[Floats, Floats], bool]
"""Whether the straight motion from a configuration (dof,) by a difference (dof,) is taken for free."""


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

    def concatenate(self, more: Proofs) -> Proofs:
        """These segments, then ``more``."""
        both = ((getattr(self, one.name), getattr(more, one.name)) for one in fields(self))
        return Proofs(*(np.concatenate(pair) for pair in both))

    @staticmethod
    def from_verdict(count: int, verdict: Verdict) -> Proofs:
        """``count`` segments of one verdict, of which nothing else is known."""
        nothing = np.zeros(count, dtype=np.int64)
        return Proofs(nothing + int(verdict), nothing - 1, nothing, np.full(count, np.inf))


class EdgeProver:
    """Proves motions in one world with one exact checker; one implementation whatever the backend.

        prover = EdgeProver(checker)
        prover.free(a, robot.difference(a, b))               # (m,) True where proven; straight ones, (m, dof) each
        prover.prove(a, robot.difference(a, b)).pair         # (m,) what stopped the others

    Planes between the shapes prove; the checker says what touches where they cannot. A motion that is not decided is
    ``Verdict.UNDECIDED``: never treat that as free. Once ``progress`` is asked to stop, everything that is still open
    is undecided; it hears how many motions are done if they are a ``stage``. What the world's motions keep
    (:class:`planner.constraints.path_constraints.PathConstraints`) is proven of all that is called free; what is not
    proven to keep it is undecided, with no pair. So is a motion on which a slide leaves what its limits allow, as
    reaches hold no farther; limits of other joints are not looked at. :class:`PlannerError` for arrays of other shapes,
    or with what is no finite number.
    """

    def __init__(self, checker: CollisionChecker, progress: Progress = QUIET, stage: str = "") -> None:
        self.checker, self.progress, self.stage = checker, progress, stage
        self.world: World = checker.world
        self.robot = checker.robot
        self.native, self.bounds = checker.bound.native, checker.bound.motion_bounds
        self.static_contact = checker.static_contact

    def only(self, pairs: Bools) -> EdgeProver:
        """A prover of these ``pairs`` (pairs,) alone: what it calls free may touch in others."""
        left_out = self.bounds.left_out
        if np.shape(pairs) != left_out.shape:
            raise ArrayError(f"pairs has shape {np.shape(pairs)}: give one truth value for each of {left_out.size}.")
        part = copy.copy(self)
        part.bounds = self.native.bounds(self.world.pair_reach, self.world.reach.bodies, left_out | ~pairs)
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
        prove, constraints, inside = self.native.prove_motion, self.world.constraints, self.checker.inside

        def free(first: Floats, delta: Floats) -> bool:
            """Whether one motion is proven, and what is kept by it too."""
            found = (
                None
                if self.static_contact is not None or self.progress.stopped
                else prove(self.bounds, first, delta, room)
            )
            if found is None or inside.pairs(first[None])[0] >= 0:
                return False
            if constraints and not constraints.proven(np.stack([first, delta])[None])[0]:
                return False
            self.note(first[None], delta[None], np.array(found[:1]), np.array(found[1:]))
            return True

        return free

    def allowed(self, start: Floats, delta: Floats, allows: MotionTest | None) -> Bools:
        """(m,) which motions without a crossed surface have no body inside another, and pass a test of the caller."""
        allowed = self.checker.inside.pairs(start) < 0
        return allowed if allows is None else allowed & allows(start, delta)

    def note(self, start: Floats, delta: Floats, clearance: Floats, samples: Ints) -> None:
        """A subclass may keep what is found of free motions from ``start`` by ``delta`` (m, dof)."""

    def note_pieces(self, path: Floats, rows: Floats, parts: Ints) -> None:
        """That ``rows`` (k, dof) cut the proven motions of a ``path`` (m + 1, dof) into ``parts`` (m,); not kept."""

    def prove_curves(self, coefficients: Floats, room: float = PROOF, contacts: bool = True) -> Proofs:
        """Verdicts on polynomial pieces q(s) = sum_k c_k s^k, s in [0, 1]; ``coefficients`` (m, degree + 1, dof).

        As :meth:`prove`, with the largest |q'| on an interval in place of |delta|, bounded by Bernstein coefficients.
        Joint limits are not looked at, but for those of slides.
        """
        coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", self.robot.dof), most=_LARGEST)
        if self.static_contact is not None:
            return Proofs.from_verdict(len(coefficients), Verdict.COLLIDES)
        kept = self.world.constraints.proven(coefficients)
        if kept.all():
            return self._proven_free(coefficients, room, contacts)
        rows = np.arange(len(kept)) if contacts else np.flatnonzero(kept)  # what strays is asked for contacts only
        proofs = Proofs.from_verdict(len(kept), Verdict.UNDECIDED)
        found = self._proven_free(coefficients[rows], room, contacts)
        for one in fields(found):
            getattr(proofs, one.name)[rows] = getattr(found, one.name)
        proofs.verdict[~kept & proofs.free] = Verdict.UNDECIDED
        return proofs

    def _proven_free(self, coefficients: Floats, room: float, contacts: bool) -> Proofs:
        """As :meth:`prove_curves`, whatever motions keep besides."""
        self.progress(self.stage, 0, len(coefficients))
        proofs, where = self._prove_batch(coefficients[:_BATCH], room)
        for first in range(_BATCH, len(coefficients), _BATCH):
            self.progress(self.stage, first, len(coefficients))
            if self.progress.stopped:
                proofs = proofs.concatenate(Proofs.from_verdict(len(coefficients) - first, Verdict.UNDECIDED))
                break
            more, there = self._prove_batch(coefficients[first : first + _BATCH], room)
            proofs, where = proofs.concatenate(more), np.append(where, there)
        self.progress(self.stage, len(coefficients), len(coefficients))
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
            if self.progress.stopped or self.native.prove_together(self.bounds, batch, room)[0].any():
                return False
        return self.kept(coefficients)

    def kept(self, coefficients: Floats) -> bool:
        """Of pieces that cross no surface, whether none begins inside something, and all keep what motions keep."""
        if (self.checker.inside.pairs(coefficients[:, 0]) >= 0).any():
            return False
        return bool(self.world.constraints.proven(coefficients).all())

    def _prove_batch(self, coefficients: Floats, room: float) -> tuple[Proofs, Floats]:
        """The proofs, and where those stopped that are undecided."""
        verdict, pair, samples, clearance, where = self.native.prove(self.bounds, coefficients, room)
        return Proofs(verdict, pair, samples, clearance), where

    def _find_contacts(self, proofs: Proofs, coefficients: Floats, where: Floats) -> None:
        """Which undecided pieces collide where their proofs stopped, by the checker."""
        stopped = np.flatnonzero(proofs.pair >= 0)
        if not len(stopped):
            return
        q = evaluate(coefficients[stopped], where[stopped])
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
