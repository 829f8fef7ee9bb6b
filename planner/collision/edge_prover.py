"""Proofs that joint motions are free between samples, by clearance (Schwarzer, Saha, Latombe 2005).

Two bodies at distance d cannot touch while they move less than d against each other. A joint motion dq moves no point
farther than |dq| times its largest distance from the joint axis, so every sample clears an interval of the path. When
the intervals of every pair cover the path, all configurations on it are proven free. The loop is compiled:
``native/source/prover.hpp``.
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

_BATCH = 256  # pieces between two checks for interruption

MotionTest = Callable[[Floats, Floats], Bools]
"""Return which motions (m,) from configurations (m, dof) by differences (m, dof) are allowed."""

MotionCheck = Callable[[Floats, Floats], bool]
"""Return whether the straight motion from a configuration (dof,) by a difference (dof,) is free."""


class Verdict(IntEnum):
    """Verdict on a segment."""

    FREE = 0  # proven
    COLLIDES = 1  # a configuration on it is in contact or within the margin
    UNDECIDED = 2  # the clearance falls below the resolution: neither proven nor refuted


_LARGEST = 100.0 * FARTHEST  # rad (m): coefficients of a curve may exceed its values
_FREE = int(Verdict.FREE)  # NumPy takes several times as long to compare with a member


@dataclass(frozen=True, eq=False)
class Proofs:
    """Verdicts on a batch of segments, and the samples that they needed."""

    verdict: Ints  # (m,) of Verdict
    pair: Ints  # (m,) the pair that stopped a segment, -1 where it is free
    samples: Ints  # (m,) configurations sampled
    # (m,) m, a lower bound on the distance beyond the margin along a free segment, of the pairs that a joint can move
    clearance: Floats

    @property
    def free(self) -> Bools:
        return self.verdict == _FREE

    def concatenate(self, more: Proofs) -> Proofs:
        """Return these segments followed by ``more``."""
        both = ((getattr(self, one.name), getattr(more, one.name)) for one in fields(self))
        return Proofs(*(np.concatenate(pair) for pair in both))

    @staticmethod
    def from_verdict(count: int, verdict: Verdict) -> Proofs:
        """Return ``count`` segments with one verdict and no other information."""
        nothing = np.zeros(count, dtype=np.int64)
        return Proofs(nothing + int(verdict), nothing - 1, nothing, np.full(count, np.inf))


class EdgeProver:
    """Proofs of motions in one world; independent of the backend.

        prover = EdgeProver(checker)
        prover.free(a, robot.difference(a, b))               # (m,) True where proven; straight, (m, dof) each
        prover.prove(a, robot.difference(a, b)).pair         # (m,) the pair that stopped each of the others

    Separating planes prove; the checker decides contact where they cannot. Never treat ``Verdict.UNDECIDED`` as free.
    After ``progress`` is interrupted, the remaining motions are undecided; a nonempty ``stage`` reports the count. Free
    motions also satisfy the world's path constraints (:class:`planner.constraints.path_constraints.PathConstraints`);
    one that is not proven to do so is undecided, with no pair. So is one on which a sliding joint leaves its limits,
    where the reach is not valid; limits of other joints are not checked. Raises :class:`PlannerError` for wrong shapes
    or values that are not finite.
    """

    def __init__(self, checker: CollisionChecker, progress: Progress = QUIET, stage: str = "") -> None:
        self.checker, self.progress, self.stage = checker, progress, stage
        self.world: World = checker.world
        self.robot = checker.robot
        self.native, self.bounds = checker.bound.native, checker.bound.motion_bounds
        self.static_contact = checker.static_contact

    def only(self, pairs: Bools) -> EdgeProver:
        """Return a prover of some ``pairs`` (pairs,) alone; its free motions may touch in other pairs."""
        left_out = self.bounds.left_out
        if np.shape(pairs) != left_out.shape:
            raise ArrayError(f"pairs has shape {np.shape(pairs)}: give one truth value for each of {left_out.size}.")
        part = copy.copy(self)
        part.bounds = self.native.bounds(self.world.pair_reach, self.world.reach.bodies, left_out | ~pairs)
        return part

    def _touching(self, rotation: Floats, position: Floats, pairs: Ints) -> int | None:
        """Return the first of ``pairs`` that the checker finds within the margin, or None."""
        gaps = self.checker.distances(rotation, position, pairs) if len(pairs) else np.zeros(0)
        touching = pairs[gaps <= self.world.margin]
        return int(touching[0]) if len(touching) else None

    def prove(self, start: Floats, delta: Floats, resolution: float = PROOF, contacts: bool = True) -> Proofs:
        """Return verdicts on the segments start + s delta, s in [0, 1]; arrays (m, dof).

        A segment is undecided if a sample has less clearance beyond the margin than ``resolution`` (m). A smaller
        resolution proves more tight segments and takes longer. Without ``contacts`` the checker is not asked, which
        halves the time, and no segment collides.
        """
        start, delta = np.atleast_2d(plain_numbers("start", start)), np.atleast_2d(plain_numbers("delta", delta))
        if start.shape != delta.shape:
            raise ArrayError(f"start has shape {start.shape} and delta {delta.shape}: give as many motions as starts.")
        return self.prove_curves(np.stack([start, delta], axis=1), resolution, contacts)

    def free(self, start: Floats, delta: Floats, resolution: float = PROOF) -> Bools:
        """Return which segments (m,) are proven free."""
        return self.prove(start, delta, resolution, contacts=False).free

    def each_free(self, resolution: float = PROOF) -> MotionCheck:
        """Return a :data:`MotionCheck` that proves one motion at a time, for one thread."""
        prove, constraints, inside = self.native.prove_motion, self.world.constraints, self.checker.inside

        def free(first: Floats, delta: Floats) -> bool:
            """Return whether one motion is proven free, with the path constraints."""
            result = (
                None
                if self.static_contact is not None or self.progress.stopped
                else prove(self.bounds, first, delta, resolution)
            )
            if result is None or inside.pairs(first[None])[0] >= 0:
                return False
            if constraints and not constraints.prove(np.stack([first, delta])[None])[0]:
                return False
            self.note(first[None], delta[None], np.array(result[:1]), np.array(result[1:]))
            return True

        return free

    def is_allowed(self, start: Floats, delta: Floats, allows: MotionTest | None) -> Bools:
        """Return which contact-free motions (m,) enclose no body and pass the caller's test."""
        allowed = self.checker.inside.pairs(start) < 0
        return allowed if allows is None else allowed & allows(start, delta)

    def note(self, start: Floats, delta: Floats, clearance: Floats, samples: Ints) -> None:
        """Record proven motions from ``start`` by ``delta`` (m, dof); a subclass may store them."""

    def note_pieces(self, path: Floats, rows: Floats, parts: Ints) -> None:
        """Record that ``rows`` (k, dof) divide the proven motions of ``path`` into ``parts`` (m,) each."""

    def prove_curves(self, coefficients: Floats, resolution: float = PROOF, contacts: bool = True) -> Proofs:
        """Return verdicts on curves q(s) = sum_k c_k s^k, s in [0, 1]; ``coefficients`` (m, degree + 1, dof).

        As :meth:`prove`, with a Bernstein bound on |q'| per interval in place of |delta|.
        """
        coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", self.robot.dof), most=_LARGEST)
        if self.static_contact is not None:
            return Proofs.from_verdict(len(coefficients), Verdict.COLLIDES)
        satisfied = self.world.constraints.prove(coefficients)
        if satisfied.all():
            return self._prove_free(coefficients, resolution, contacts)
        rows = np.arange(len(satisfied)) if contacts else np.flatnonzero(satisfied)
        proofs = Proofs.from_verdict(len(satisfied), Verdict.UNDECIDED)
        result = self._prove_free(coefficients[rows], resolution, contacts)
        for one in fields(result):
            getattr(proofs, one.name)[rows] = getattr(result, one.name)
        proofs.verdict[~satisfied & proofs.free] = Verdict.UNDECIDED
        return proofs

    def _prove_free(self, coefficients: Floats, resolution: float, contacts: bool) -> Proofs:
        """Return :meth:`prove_curves` without path constraints."""
        self.progress(self.stage, 0, len(coefficients))
        proofs, where = self._prove_batch(coefficients[:_BATCH], resolution)
        for first in range(_BATCH, len(coefficients), _BATCH):
            self.progress(self.stage, first, len(coefficients))
            if self.progress.stopped:
                proofs = proofs.concatenate(Proofs.from_verdict(len(coefficients) - first, Verdict.UNDECIDED))
                break
            more, there = self._prove_batch(coefficients[first : first + _BATCH], resolution)
            proofs, where = proofs.concatenate(more), np.append(where, there)
        self.progress(self.stage, len(coefficients), len(coefficients))
        if contacts:
            self._find_contacts(proofs, coefficients, where)
        free = np.flatnonzero(proofs.free)
        self._find_enclosed(proofs, coefficients[free, 0], free)
        return proofs

    def all_free(self, coefficients: Floats, resolution: float = PROOF) -> bool:
        """Return whether all curves (m, degree + 1, dof) are proven free.

        It stops at the first failure. If neighbours are close to each other, it takes half the time of
        :meth:`prove_curves`.
        """
        coefficients = numbers("coefficients", coefficients, ("m", "degree + 1", self.robot.dof), most=_LARGEST)
        if self.static_contact is not None:
            return False
        for first in range(0, len(coefficients), _BATCH):
            batch = coefficients[first : first + _BATCH]
            if self.progress.stopped or self.native.prove_together(self.bounds, batch, resolution)[0].any():
                return False
        return self.keeps_constraints(coefficients)

    def keeps_constraints(self, coefficients: Floats) -> bool:
        """Return whether contact-free curves start outside of meshes and satisfy the path constraints."""
        if (self.checker.inside.pairs(coefficients[:, 0]) >= 0).any():
            return False
        return bool(self.world.constraints.prove(coefficients).all())

    def _prove_batch(self, coefficients: Floats, resolution: float) -> tuple[Proofs, Floats]:
        """Return the proofs, and s where each undecided one stopped."""
        verdict, pair, samples, clearance, where = self.native.prove(self.bounds, coefficients, resolution)
        return Proofs(verdict, pair, samples, clearance), where

    def _find_contacts(self, proofs: Proofs, coefficients: Floats, where: Floats) -> None:
        """Mark undecided curves that collide, by the checker, where their proofs stopped."""
        stopped = np.flatnonzero(proofs.pair >= 0)
        if not len(stopped):
            return
        q = evaluate(coefficients[stopped], where[stopped])
        rotation, position = joint_placements(self.checker.chain, q)
        for k, row in enumerate(stopped):
            pair = proofs.pair[row : row + 1]
            if self._touching(rotation[:, k], position[:, k], pair) is not None:
                proofs.verdict[row] = Verdict.COLLIDES
        self._find_enclosed(proofs, q, stopped)

    def _find_enclosed(self, proofs: Proofs, states: Floats, rows: Ints) -> None:
        """Mark the curves ``rows`` (k,) of which a body is enclosed in the given state (dof,) of each.

        Without contact of surfaces, enclosure holds along the whole curve.
        """
        inside = self.checker.inside.pairs(states)
        proofs.verdict[rows[inside >= 0]] = Verdict.COLLIDES
        proofs.pair[rows[inside >= 0]] = inside[inside >= 0]
