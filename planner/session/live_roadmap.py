"""A roadmap in a world that changes, and what is known of every edge, part of the world by part of the world.

A part is the arm with all its links, something that the arm carries, or an obstacle. A clause of an edge's proof is
about two parts: how far they stay apart along the edge at least. Where a part moves, only its clauses are spent; where
it goes, only its clauses go, and what it alone had blocked is proven again without a check.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.collision.world import World
from planner.roadmap.load_or_build import reprove_if_needed
from planner.roadmap.measure import check_nodes, unchecked
from planner.roadmap.roadmap import (
    EDGE_ARRAYS,
    NODE_ARRAYS,
    Roadmap,
    edge_motions,
    record_origin,
    restrict_to_constraints,
)
from planner.robot.shapes import Carried, Obstacle, Shape, corners

ARM = ""  # the part that all links of the robot are
_BLOCKED = -np.inf
_ROUNDING = 1e-9  # m
_PER_EDGE = ("known", "lost", "seen")

Clause = tuple[str, str]
"""Two parts by name; the arm, or what it carries, first."""


@dataclass(frozen=True)
class Edges:
    """What became of a roadmap's edges in one call.

    ``proven`` anew by a check; ``removed``: they were free and a proof failed; ``regained``: they were blocked and are
    free; ``opened``: they were free, and have to be proven again before a path uses them.
    """

    proven: int = 0
    removed: int = 0
    regained: int = 0
    opened: int = 0

    def __add__(self, other: Edges) -> Edges:
        return Edges(*(a + b for a, b in zip(astuple(self), astuple(other), strict=True)))


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
    def from_clearance(world: World, clearance: Floats) -> EdgeProofs:
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

    def move_to_world(self, before: World, after: World) -> EdgeProofs:
        """The proofs after the world ``before``, in which they hold, has become the world ``after``.

        An obstacle that moved spends the clearance of its clauses by its displacement. Clauses of new parts are open,
        and so are those of parts that have another shape, hold or set of allowed contacts than before.
        """
        column = {clause: k for k, clause in enumerate(self.clauses)}
        parts = _objects_of(before), _objects_of(after)
        clauses = clauses_of(after)[0]
        known = np.full((len(self.known), len(clauses)), np.nan)
        seen = np.zeros(known.shape, dtype=bool)
        for k, clause in enumerate(clauses):
            by = sum(_measure_shift(parts[0].get(name), parts[1].get(name)) for name in set(clause) - {ARM})
            if clause in column and by < np.inf:
                old = self.known[:, column[clause]]
                left = old - (by + _ROUNDING)
                known[:, k] = np.where(left > 0, left, np.nan) if by > 0 else old
                seen[:, k] = self.seen[:, column[clause]]
        return EdgeProofs(clauses, known, self.lost, seen)

    def select(self, rows: Ints | Bools) -> EdgeProofs:
        """Of some edges."""
        return replace(self, **{name: getattr(self, name)[rows] for name in _PER_EDGE})

    def append(self, other: EdgeProofs) -> EdgeProofs:
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

    def prove(self, prover: EdgeProver, roadmap: Roadmap, rows: Ints) -> EdgeProofs:
        """After a proof of what is open of the edges ``rows`` of the roadmap, and of nothing else."""
        clause = clauses_of(prover.world)[1]
        known = np.array(self.known)
        patterns, of_row = np.unique(np.isnan(known[rows]), axis=0, return_inverse=True)
        for k, wanted in enumerate(patterns):
            these = rows[of_row.ravel() == k]
            proofs = prover.only(wanted[clause]).prove(*edge_motions(roadmap, prover.robot, these))
            free, blocked = these[proofs.free], these[~proofs.free]
            known[np.ix_(free, wanted)] = np.maximum(proofs.clearance[proofs.free], 0.0)[:, None]
            known[blocked, clause[proofs.pair[~proofs.free]]] = _BLOCKED
        return replace(self, known=known)

    def confirm(self, rows: Ints) -> EdgeProofs:
        """After a second check found nothing on the edges ``rows``."""
        seen = np.array(self.seen)
        seen[rows] = True
        return replace(self, seen=seen)

    def refuse(self, row: int) -> EdgeProofs:
        """After a second check found a contact on the edge ``row``, which no proof did."""
        known = np.array(self.known)
        known[row] = _BLOCKED
        return replace(self, known=known)


def _objects_of(world: World) -> dict[str, tuple[Obstacle | Carried, frozenset[frozenset[str]]]]:
    """Obstacles and carried things by name, each with the contacts that the scene allows it."""
    scene = world.scene
    items = (*scene.obstacles, *scene.carried)
    return {item.name: (item, frozenset(pair for pair in scene.allowed if item.object in pair)) for item in items}


def _measure_shift(before: tuple[Any, frozenset[Any]] | None, after: tuple[Any, frozenset[Any]] | None) -> float:
    """How far (m) a part moved at most; infinite where it is another part than before."""
    if before is None or after is None or before[1] != after[1]:
        return np.inf
    old, new = before[0], after[0]
    if old is new:
        return 0.0
    if isinstance(old, Carried) or isinstance(new, Carried) or old.shape is not new.shape:
        return np.inf
    return measure_displacement(old.shape, old.placement, new.placement)


def measure_displacement(shape: Shape, before: Floats, after: Floats) -> float:
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


@dataclass(frozen=True, eq=False)
class LiveRoadmap:
    """A roadmap, the world of its ``checker``, and what is known there.

    ``kept`` is the roadmap (None before the first query): it holds every edge that was ever proven, ``proofs`` what is
    known of each now. Its first ``lasting`` nodes stay, the others came with queries. ``x`` (n,): the field over its
    nodes that the last query left behind.
    """

    checker: CollisionChecker
    proofs: EdgeProofs
    kept: Roadmap | None = None
    lasting: int = 0
    x: Floats = field(default_factory=lambda: np.zeros(0))

    @staticmethod
    def from_checker(checker: CollisionChecker) -> LiveRoadmap:
        """No roadmap yet."""
        return LiveRoadmap(checker, EdgeProofs.from_clearance(checker.world, np.zeros(0)))

    @property
    def roadmap(self) -> Roadmap:
        assert self.kept is not None  # callers check this
        return self.kept

    @property
    def world(self) -> World:
        return self.checker.world

    def with_roadmap(self, roadmap: Roadmap) -> LiveRoadmap:
        """With a roadmap that is proven in this very world."""
        proofs = EdgeProofs.from_clearance(self.world, roadmap.clearance + (roadmap.origin.margin - self.world.margin))
        n = len(roadmap.nodes)
        return replace(self, kept=roadmap, proofs=proofs, lasting=n, x=np.full(n, np.inf))

    def with_foreign_roadmap(self, roadmap: Roadmap) -> LiveRoadmap:
        """With a roadmap of the same joints in any world, as far as it holds in this one."""
        roadmap = reprove_if_needed(roadmap, self.checker)
        return self.with_roadmap(check_nodes(restrict_to_constraints(roadmap, self.world.constraints), self.checker))

    def move_to_world(self, checker: CollisionChecker) -> LiveRoadmap:
        """The same roadmap in the world of another ``checker``."""
        if checker is self.checker:
            return self
        kept = None if self.kept is None else replace(self.kept, checked_by=unchecked(len(self.kept.nodes)))
        return replace(self, checker=checker, kept=kept, proofs=self.proofs.move_to_world(self.world, checker.world))

    def prove(self, rows: Ints) -> LiveRoadmap:
        """After a proof of what is open of the edges ``rows``."""
        return (
            replace(self, proofs=self.proofs.prove(EdgeProver(self.checker), self.roadmap, rows)) if len(rows) else self
        )

    def with_edges(self, edges: Bools) -> Roadmap:
        """The roadmap of all nodes and of some ``edges`` (m,), with what is known of these now."""
        clearance = np.maximum(np.nan_to_num(self.proofs.clearance, nan=0.0, posinf=np.inf), 0.0)
        whole = replace(
            self.roadmap,
            proven=self.proofs.free,
            clearance=clearance,
            origin=record_origin(self.checker, self.roadmap.origin.seed),
        )
        return whole.part(np.ones(len(whole.nodes), dtype=bool), edges)

    def enlarge(self, bigger: Roadmap) -> LiveRoadmap:
        """With what a roadmap that grew from a part of this one has more: nodes after ours, edges proven just now."""
        n, old = len(bigger.nodes), self.roadmap
        mine, theirs = (edges[:, 0] * n + edges[:, 1] for edges in (old.edges, bigger.edges))
        known_free = mine[self.proofs.free | self.proofs.open]
        fresh = ~np.isin(theirs, known_free)
        kept = ~np.isin(mine, theirs[fresh])
        whole = {name: np.concatenate([getattr(old, name)[kept], getattr(bigger, name)[fresh]]) for name in EDGE_ARRAYS}
        order = np.argsort(np.concatenate([mine[kept], theirs[fresh]]), kind="stable")
        new = EdgeProofs.from_clearance(self.world, bigger.clearance[fresh])
        arrays = {name: array[order] for name, array in whole.items()}
        nodes = {name: getattr(bigger, name) for name in NODE_ARRAYS}
        roadmap = replace(old, starts=bigger.starts, goals=bigger.goals, **nodes, **arrays)
        x = np.concatenate([self.x, np.full(n - len(self.x), np.inf)])
        return replace(self, kept=roadmap, proofs=self.proofs.select(kept).append(new).select(order), x=x)

    def without_nodes(self, keep: Bools) -> LiveRoadmap:
        """With the nodes (n,) in ``keep`` and the edges between them only."""
        edges: Bools = np.all(keep[self.roadmap.edges], axis=1)
        return replace(self, kept=self.roadmap.part(keep, edges), proofs=self.proofs.select(edges), x=self.x[keep])
