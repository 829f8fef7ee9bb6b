"""Proofs that a straight joint-space segment is free: adaptive sampling with clearance (Schwarzer, Saha, Latombe 2005).

Where a pair of bodies is d apart, no motion that moves them against each other by less than d can make them touch.
A joint's motion dq moves no point further than its reach times |dq|, so every look at one configuration
clears an interval of the segment; when the intervals of every pair cover it, the segment is proven, for all
the configurations on it and not just for those that were sampled.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.products import product
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF
from planner.collision.checker import CollisionChecker
from planner.collision.world import Contact, World
from planner.kinematics.forward import joint_placements

_REFINE = 0.08  # m: pairs that a coarse bound puts nearer than this get a closer look where it falls short
_EXACT = 0.02  # m: and nearer than this the exact distance
_PIECE = 0.35  # m: first intervals move no point further than this


class Verdict(IntEnum):
    """What is known about a segment."""

    FREE = 0  # proven
    COLLIDES = 1  # a configuration on it touches, or comes closer than the margin
    UNDECIDED = 2  # it passes closer than the resolution: neither proven nor refuted


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
        return self.verdict == Verdict.FREE


class EdgeProver:
    """Proves segments in one world with one exact checker; one implementation whatever the backend.

        prover = EdgeProver(checker)
        proofs = prover.prove(a, robot.difference(a, b))     # (m, dof) each
        proofs.free                                          # (m,) True where proven

    A segment that it cannot decide is ``Verdict.UNDECIDED``: never treat that as free. Once ``progress`` is asked to
    stop, everything that is still open is undecided.
    """

    def __init__(self, checker: CollisionChecker, progress: Progress = QUIET) -> None:
        self.checker, self.progress = checker, progress
        self.world: World = checker.world
        self.robot = checker.robot
        self.bound = checker.bound
        self._reach_T = np.ascontiguousarray(self.world.pair_reach.T)
        self._static = np.nonzero(~self.world.pair_reach.any(axis=1))[0]
        self._refinable = np.array([self.bound.can_refine(p) for p in range(len(self.world.pair_reach))], dtype=bool)
        self.static_contact = self._find_static_contact()

    def _find_static_contact(self) -> Contact | None:
        """A pair that no joint can move (the base and an obstacle), if it touches."""
        rotation, position = joint_placements(self.checker.chain, np.zeros((1, self.world.robot.dof)))
        pairs = np.array([p for p in self._static if self._is_checked(int(p))], dtype=np.int64)
        gaps = self.checker.distances(rotation[:, 0], position[:, 0], pairs) if len(pairs) else np.zeros(0)
        touching = pairs[gaps <= self.world.margin]
        return self.world.contact(int(touching[0])) if len(touching) else None

    def _is_checked(self, pair: int) -> bool:
        first, second = self.world.members(pair)
        return not self.world.is_scene_pair(pair) or bool(self.world.checked[first, second])

    def prove(self, start: Floats, delta: Floats, room: float = PROOF) -> Proofs:
        """Verdicts on the segments start + s delta, s in [0, 1]; arrays (m, dof).

        A segment is undecided where a sample has less than ``room`` (m) of clearance beyond the margin. A smaller
        ``room`` proves more of the tight segments, and takes longer on each of them.
        """
        start = np.atleast_2d(start)
        proofs = _Run(self, start, np.atleast_2d(delta), room).finish()
        free = np.flatnonzero(proofs.free)
        inside = self.checker.inside.pairs(start[free])  # where no surface is crossed, that holds for the whole segment
        proofs.verdict[free[inside >= 0]] = Verdict.COLLIDES
        proofs.pair[free[inside >= 0]] = inside[inside >= 0]
        return proofs


class _Run:
    """One batch: in each round every open interval is sampled in its middle."""

    def __init__(self, prover: EdgeProver, start: Floats, delta: Floats, room: float) -> None:
        self.prover, self.start, self.delta, self.room = prover, start, delta, room
        m = len(start)
        self.verdict = np.full(m, Verdict.FREE, dtype=np.int64)
        self.pair = np.full(m, -1, dtype=np.int64)
        self.samples = np.zeros(m, dtype=np.int64)
        self.clearance = np.full(m, np.inf)
        # (m, pairs): metres by which a pair's distance can change along the whole segment
        self.rate = product(np.abs(delta), prover._reach_T)
        self.rate[:, prover._static] = 0.0
        self.contact_is_static = prover.static_contact is not None

    def finish(self) -> Proofs:
        """Sample until every interval is cleared or its segment is decided otherwise."""
        if self.contact_is_static:
            self.verdict[:] = Verdict.COLLIDES
        elif self.rate.shape[1]:  # with no pair to check everything is free
            edge, low, high = self._first_intervals()
            while len(edge):
                edge, low, high = self._round(edge, low, high)
                if self.prover.progress.stopped:
                    self.verdict[edge] = Verdict.UNDECIDED
                    break
        return Proofs(self.verdict, self.pair, self.samples, self.clearance)

    def _first_intervals(self) -> tuple[Ints, Floats, Floats]:
        motion = self.rate.max(axis=1, initial=0.0)
        pieces = np.maximum(1, np.ceil(motion / _PIECE)).astype(np.int64)
        edge = np.repeat(np.arange(len(pieces)), pieces)
        first = np.repeat(np.cumsum(pieces) - pieces, pieces)
        low = (np.arange(len(edge)) - first) / pieces[edge]
        return edge, low, low + 1.0 / pieces[edge]

    def _round(self, edge: Ints, low: Floats, high: Floats) -> tuple[Ints, Floats, Floats]:
        middle, need = 0.5 * (low + high), 0.5 * (high - low)
        np.add.at(self.samples, edge, 1)
        q = self.start[edge] + middle[:, None] * self.delta[edge]
        placements = joint_placements(self.prover.checker.chain, q)
        rate = self.rate[edge]
        gap = self._gaps(edge, rate, need, *placements)
        with np.errstate(divide="ignore", invalid="ignore"):
            cleared = np.where(rate > 0, gap / rate, np.inf)
        limit, rows = cleared.argmin(axis=1), np.arange(len(edge))
        reach = cleared[rows, limit]
        stuck = (reach < need) & (gap[rows, limit] < self.room)
        self._note_clearance(edge, gap, rate, np.minimum(reach, need))
        for k in np.nonzero(stuck)[0]:
            self._stop(int(edge[k]), int(limit[k]), Verdict.UNDECIDED)
        open_ = (reach < need) & (self.verdict[edge] == Verdict.FREE)
        e, lo, hi, mid, r = edge[open_], low[open_], high[open_], middle[open_], reach[open_]
        return np.concatenate([e, e]), np.concatenate([lo, mid + r]), np.concatenate([mid - r, hi])

    def _note_clearance(self, edge: Ints, gap: Floats, rate: Floats, covered: Floats) -> None:
        left = gap - rate * covered[:, None]
        np.minimum.at(self.clearance, edge, left.min(axis=1))

    def _stop(self, edge: int, pair: int, verdict: Verdict) -> None:
        if self.verdict[edge] != Verdict.COLLIDES:
            self.verdict[edge], self.pair[edge] = verdict, pair

    def _gaps(self, edge: Ints, rate: Floats, need: Floats, rotation: Floats, position: Floats) -> Floats:
        """Lower bounds (n, pairs) on the distance beyond the margin, as close as it takes to cover ``need``."""
        prover, margin = self.prover, self.prover.world.margin
        gap = prover.bound.coarse(rotation, position) - margin
        gap[:, prover._static] = np.inf
        wanted = rate * need[:, None]
        rows, pairs = np.nonzero((gap < wanted) & (gap < _REFINE) & prover._refinable)
        if len(rows):
            closer = prover.bound.refine(rotation, position, rows, pairs) - margin
            gap[rows, pairs] = np.maximum(gap[rows, pairs], closer)
        # a pair that this segment does not move needs a look only where the bound cannot clear it
        short = (gap < np.minimum(wanted, _EXACT)) | ((wanted == 0) & (gap <= 0))
        for row in np.nonzero(short.any(axis=1))[0]:
            if prover.progress.stopped:
                break  # what is there bounds the distance too
            self._look_exactly(
                int(edge[row]),
                gap[row],
                np.nonzero(short[row])[0],
                rate[row],
                rotation[:, row],
                position[:, row],
            )
        return gap

    def _look_exactly(
        self, edge: int, gap: Floats, pairs: Ints, rate: Floats, rotation: Floats, position: Floats
    ) -> None:
        """Replace one configuration's bounds by distances less their error; the likeliest contact first."""
        if self.verdict[edge] != Verdict.FREE:
            return
        checker, margin = self.prover.checker, self.prover.world.margin
        pairs = pairs[np.argsort(gap[pairs], kind="stable")]
        for pair, distance in zip(pairs, checker.bounding_distances(rotation, position, pairs), strict=True):
            if distance <= margin:
                self._stop(edge, int(pair), Verdict.COLLIDES)
                return
            gap[pair] = max(gap[pair], distance - checker.error(distance) - margin, 0.0 if rate[pair] == 0 else -np.inf)


def states_along(start: Floats, delta: Floats, motion: float, step: float) -> Floats:
    """Configurations along a segment, both ends included, between which no point moves further than ``step`` (m).

    ``motion`` is the most that any point moves on the whole segment.
    """
    count = max(1, int(np.ceil(motion / step)))
    return start + np.linspace(0.0, 1.0, count + 1)[:, None] * delta


def recheck(checker: CollisionChecker, start: Floats, delta: Floats, step: float = 1e-3) -> Contact | None:
    """The first contact on a segment sampled every ``step`` metres of motion, without bounds or proofs; else None."""
    motion = float(checker.world.reach.motion(delta[None]).max(initial=0.0))
    found = checker.first_contact(states_along(start, delta, motion, step))
    return found[1] if found else None
