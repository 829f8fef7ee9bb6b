"""What is known of every edge, part of the world by part of the world, so that a change touches what it concerns.

A part is the arm with all its links, something that the arm carries, or an obstacle. A clause of an edge's proof is
about two parts: how far they stay apart along the edge at least. Where a part moves, only its clauses are spent; where
it goes, only its clauses go, and what it alone had blocked is proven again without a check.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.collision.edge_prover import EdgeProver
from planner.collision.world import World
from planner.planning.result import Edges
from planner.roadmap.obtain import batches
from planner.roadmap.roadmap import Roadmap, segments
from planner.robot.shapes import Carried, Obstacle, Shape, corners

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

    def in_world(self, before: World, after: World) -> EdgeProofs:
        """The proofs after the world ``before``, in which they hold, has become the world ``after``.

        An obstacle that moved spends the clearance of its clauses by its displacement. Clauses of new parts are open,
        and so are those of parts that have another shape, hold or set of allowed contacts than before.
        """
        column = {clause: k for k, clause in enumerate(self.clauses)}
        parts = _parts_of(before), _parts_of(after)
        clauses = clauses_of(after)[0]
        known = np.full((len(self.known), len(clauses)), np.nan)
        seen = np.zeros(known.shape, dtype=bool)
        for k, clause in enumerate(clauses):
            by = sum(_shift(parts[0].get(name), parts[1].get(name)) for name in set(clause) - {ARM})
            if clause in column and by < np.inf:
                old = self.known[:, column[clause]]
                left = old - (by + _ROUNDING)
                known[:, k] = np.where(left > 0, left, np.nan) if by > 0 else old
                seen[:, k] = self.seen[:, column[clause]]
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


def _parts_of(world: World) -> dict[str, tuple[Obstacle | Carried, frozenset[frozenset[str]]]]:
    """Obstacles and carried things by name, each with the contacts that the scene allows it."""
    scene = world.scene
    items = (*scene.obstacles, *scene.carried)
    return {item.name: (item, frozenset(pair for pair in scene.allowed if item.object in pair)) for item in items}


def _shift(before: tuple[Any, frozenset[Any]] | None, after: tuple[Any, frozenset[Any]] | None) -> float:
    """How far (m) a part moved at most; infinite where it is another part than before."""
    if before is None or after is None or before[1] != after[1]:
        return np.inf
    old, new = before[0], after[0]
    if old is new:
        return 0.0
    if isinstance(old, Carried) or isinstance(new, Carried) or old.shape is not new.shape:
        return np.inf
    return displacement(old.shape, old.placement, new.placement)


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
