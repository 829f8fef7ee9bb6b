"""What is known of every edge, part of the world by part of the world, so that a change touches what it concerns.

A part is the arm with all its links, something that the arm carries, or an obstacle. A clause of an edge's proof is
about two parts: how far they stay apart along the edge at least. Where a part moves, only its clauses are spent; where
it goes, only its clauses go, and what it alone had blocked is proven again without a check.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.collision.edge_prover import EdgeProver
from planner.collision.world import World
from planner.planning.result import Edges
from planner.roadmap.reprove import batches
from planner.roadmap.roadmap import Roadmap, segments
from planner.robot.shapes import Shape, corners

ARM = ""  # the part that all links of the robot are
_BLOCKED = -np.inf
_ROUNDING = 1e-9  # m
_PER_EDGE = ("known", "lost", "seen")

Clause = tuple[str, str]
"""Two parts by name; the arm, or what it carries, first."""


@dataclass(frozen=True, eq=False)
class EdgeProofs:
    """``known`` (m, clauses): metres beyond the margin that a clause's two parts stay apart along an edge at least.

    NaN where that is open (to be proven), -inf where a proof failed. An edge is free where all is proven, blocked where
    a clause failed; else it is open. ``lost`` (m,): which were blocked when that was last decided. ``seen`` (m,
    clauses): what a second checker has confirmed; a clause that only loses clearance needs no other look.
    """

    clauses: tuple[Clause, ...]
    known: Floats
    lost: Bools
    seen: Bools

    def __post_init__(self) -> None:
        object.__setattr__(self, "known", frozen(self.known))
        object.__setattr__(self, "lost", frozen((self.lost | self.blocked) & ~self.free, np.bool_))
        object.__setattr__(self, "seen", frozen(self.seen & (self.known >= 0), np.bool_))

    @staticmethod
    def of(world: World, clearance: Floats) -> EdgeProofs:
        """Edges that are proven in ``world``, each with its ``clearance`` (m,)."""
        clauses = clauses_of(world)[0]
        known = np.repeat(clearance[:, None], len(clauses), axis=1)
        return EdgeProofs(clauses, known, np.zeros(len(known), dtype=bool), np.zeros(known.shape, dtype=bool))

    @cached_property
    def clearance(self) -> Floats:
        """(m,) the least that is known of an edge, metres; NaN for open ones, -inf for blocked ones."""
        return np.where(self.blocked, _BLOCKED, self.known.min(axis=1, initial=np.inf))

    @cached_property
    def free(self) -> Bools:
        """(m,) which edges are proven."""
        return np.all(self.known >= 0, axis=1)

    @cached_property
    def blocked(self) -> Bools:
        """(m,) which edges have a clause whose proof failed."""
        return np.any(self.known == _BLOCKED, axis=1)

    @cached_property
    def open(self) -> Bools:
        """(m,) which edges are neither."""
        return ~self.free & ~self.blocked

    def moved(self, part: str, by: float) -> EdgeProofs:
        """After no point of ``part`` moved farther than ``by`` (m): its clauses lose as much, or are open again."""
        known = np.array(self.known)
        for k, clause in enumerate(self.clauses):
            if part in clause:
                left = known[:, k] - (by + _ROUNDING)
                known[:, k] = np.where(left > 0, left, np.nan)
        return replace(self, known=known)

    def in_world(self, world: World, other: str | None = None) -> EdgeProofs:
        """With the clauses of another ``world``: those that are new are open, those that are gone are forgotten.

        ``other``: the part that was something else before, whose clauses are new although they are called as before.
        """
        clauses = clauses_of(world)[0]
        if clauses == self.clauses and other is None:
            return self
        known = np.full((len(self.known), len(clauses)), np.nan)
        seen = np.zeros(known.shape, dtype=bool)
        place = {clause: k for k, clause in enumerate(self.clauses)}
        for k, clause in enumerate(clauses):
            if clause in place and other not in clause:
                known[:, k], seen[:, k] = self.known[:, place[clause]], self.seen[:, place[clause]]
        return EdgeProofs(clauses, known, self.lost, seen)

    def rows(self, rows: Ints | Bools) -> EdgeProofs:
        """Of some edges."""
        return replace(self, **{name: getattr(self, name)[rows] for name in _PER_EDGE})

    def followed_by(self, other: EdgeProofs) -> EdgeProofs:
        """Of these edges, then those of ``other``, in the same world."""
        return replace(
            self, **{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in _PER_EDGE}
        )

    def since(self, before: EdgeProofs, checked: bool = True) -> Edges:
        """What became of the same edges since an earlier moment; not ``checked``: what was undecided was forgotten."""
        return Edges(
            proven=int((before.open & self.free).sum()) if checked else 0,
            removed=int((~before.lost & self.lost).sum()),
            regained=int((before.lost & ~self.lost).sum()),
            opened=int((before.free & self.open).sum()),
        )

    def proven(self, prover: EdgeProver, roadmap: Roadmap, rows: Ints) -> EdgeProofs:
        """After a proof of what is open of the edges ``rows`` of the roadmap, and of nothing else."""
        clause = clauses_of(prover.world)[1]
        known = np.array(self.known)
        patterns, of_row = np.unique(np.isnan(known[rows]), axis=0, return_inverse=True)
        for k, wanted in enumerate(patterns):
            part = prover.only(wanted[clause])
            for batch in batches(rows[of_row.ravel() == k]):
                proofs = part.prove(*segments(roadmap, prover.robot, batch))
                free = batch[proofs.free]
                known[np.ix_(free, wanted)] = np.maximum(proofs.clearance[proofs.free], 0.0)[:, None]
                known[batch[~proofs.free], clause[proofs.pair[~proofs.free]]] = _BLOCKED
        return replace(self, known=known)

    def confirmed(self, rows: Ints) -> EdgeProofs:
        """After a second check found nothing on the edges ``rows``."""
        seen = np.array(self.seen)
        seen[rows] = True
        return replace(self, seen=seen)

    def refused(self, row: int) -> EdgeProofs:
        """After a second check found a contact on the edge ``row``, which no proof did: it is blocked for good."""
        known = np.array(self.known)
        known[row] = _BLOCKED
        return replace(self, known=known)


def displacement(shape: Shape, before: Floats, after: Floats) -> float:
    """How far (m) any point of a shape moves at most between two placements (4, 4)."""
    points, radius = corners(shape)
    change = np.asarray(after) - np.asarray(before)
    # the length of an affine map is convex, so no point of the hull moves farther than a corner does
    farthest = np.linalg.norm(points @ change[:3, :3].T + change[:3, 3], axis=1).max()
    return float(farthest + radius * np.linalg.norm(change[:3, :3], 2))


@lru_cache(maxsize=8)
def clauses_of(world: World) -> tuple[tuple[Clause, ...], Ints]:
    """The clauses of a world, and for each of its pairs (pairs,) the number of its clause."""
    carried = {body.name for body in world.robot.carried}
    bodies = [body.name if body.name in carried else ARM for body in world.bodies]
    obstacles = [obstacle.name for obstacle in world.obstacles]
    named = [(body, obstacle) for body in bodies for obstacle in obstacles]
    named += [(min(bodies[i], bodies[k]), max(bodies[i], bodies[k])) for i, k in world.self_pairs]
    clauses = tuple(dict.fromkeys(named))
    place = {clause: k for k, clause in enumerate(clauses)}
    return clauses, np.array([place[clause] for clause in named], dtype=np.int64)
