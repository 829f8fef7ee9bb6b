"""A roadmap in a world that changes: the proof of an edge has a clause per pair of objects.

An object is the arm with all its links, a carried object, or an obstacle. A clause bounds the distance of two objects
along an edge from below. If an object moves, only its clauses lose clearance. If it leaves, only its clauses are
dropped, and edges that it alone blocked are free again without a check.
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
from planner.roadmap.load_or_build import reprove_in_other_world
from planner.roadmap.measure import check_nodes
from planner.roadmap.roadmap import (
    EDGE_ARRAYS,
    NODE_ARRAYS,
    Roadmap,
    edge_motions,
    record_origin,
    restrict_to_constraints,
)
from planner.robot.shapes import Carried, Obstacle, Shape, corners

ARM = ""  # name of the object of all robot links
_BLOCKED = -np.inf
_ROUNDING = 1e-9  # m
_PER_EDGE = ("known", "lost", "seen")

Clause = tuple[str, str]
"""Names of two objects; the arm, or a carried object, first."""


@dataclass(frozen=True)
class EdgeChanges:
    """Counts of edges that changed in one call.

    ``proven`` by a check; ``removed``: free before, and a proof failed; ``regained``: blocked before, and free now;
    ``opened``: free before, and a path must prove them again.
    """

    proven: int = 0
    removed: int = 0
    regained: int = 0
    opened: int = 0

    def __add__(self, other: EdgeChanges) -> EdgeChanges:
        return EdgeChanges(*(a + b for a, b in zip(astuple(self), astuple(other), strict=True)))


@dataclass(frozen=True, eq=False)
class EdgeProofs:
    """``known`` (m, clauses): proven distance (m) beyond the margin of two objects along an edge.

    NaN is open (not decided), -inf a failed proof. An edge is free if all clauses are proven, blocked if one failed,
    else open. ``lost`` (m,): blocked when last decided. ``seen`` (m, clauses): confirmed by a second checker; a clause
    that only loses clearance needs no other check.
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
        """Return the proofs of edges that are proven in ``world``, with ``clearance`` (m,)."""
        clauses = clauses_of(world)[0]
        known = np.repeat(clearance[:, None], len(clauses), axis=1)
        return EdgeProofs(clauses, known, np.zeros(len(known), dtype=bool), np.zeros(known.shape, dtype=bool))

    @cached_property
    def clearance(self) -> Floats:
        """(m,) proven clearance of each edge, metres; NaN if open, -inf if blocked."""
        return np.where(self.blocked, _BLOCKED, self.known.min(axis=1, initial=np.inf))

    @cached_property
    def free(self) -> Bools:
        """(m,) whether each edge is proven."""
        return np.all(self.known >= 0, axis=1)

    @cached_property
    def blocked(self) -> Bools:
        """(m,) whether a clause of each edge failed."""
        return np.any(self.known == _BLOCKED, axis=1)

    @cached_property
    def open(self) -> Bools:
        """(m,) whether each edge is neither free nor blocked."""
        return ~self.free & ~self.blocked

    def move_to_world(self, before: World, after: World) -> EdgeProofs:
        """Return the proofs in the world ``after``, given that these hold in the world ``before``.

        The displacement of a moved obstacle reduces the clearance of its clauses. Clauses of new objects are open, and
        those of objects with another shape, grasp or set of allowed contacts.
        """
        column = {clause: k for k, clause in enumerate(self.clauses)}
        objects = _objects_of(before), _objects_of(after)
        clauses = clauses_of(after)[0]
        known = np.full((len(self.known), len(clauses)), np.nan)
        seen = np.zeros(known.shape, dtype=bool)
        for k, clause in enumerate(clauses):
            by = sum(_measure_shift(objects[0].get(name), objects[1].get(name)) for name in set(clause) - {ARM})
            if clause in column and by < np.inf:
                old = self.known[:, column[clause]]
                left = old - (by + _ROUNDING)
                known[:, k] = np.where(left > 0, left, np.nan) if by > 0 else old
                seen[:, k] = self.seen[:, column[clause]]
        return EdgeProofs(clauses, known, self.lost, seen)

    def select(self, rows: Ints | Bools) -> EdgeProofs:
        """Return the proofs of some edges."""
        return replace(self, **{name: getattr(self, name)[rows] for name in _PER_EDGE})

    def append(self, other: EdgeProofs) -> EdgeProofs:
        """Return the proofs of these edges followed by those of ``other``, in the same world."""
        return replace(
            self, **{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in _PER_EDGE}
        )

    def since(self, before: EdgeProofs, checked: bool = True) -> EdgeChanges:
        """Count changes of the same edges since ``before``; without ``checked`` no check has proven one."""
        return EdgeChanges(
            proven=int((before.open & self.free).sum()) if checked else 0,
            removed=int((~before.lost & self.lost).sum()),
            regained=int((before.lost & ~self.lost).sum()),
            opened=int((before.free & self.open).sum()),
        )

    def prove(self, prover: EdgeProver, roadmap: Roadmap, rows: Ints) -> EdgeProofs:
        """Prove the open clauses, and no others, of the edges ``rows`` of the roadmap."""
        clause = clauses_of(prover.world)[1]
        known = np.array(self.known)
        patterns, of_row = np.unique(np.isnan(known[rows]), axis=0, return_inverse=True)
        for k, is_open in enumerate(patterns):
            these = rows[of_row.ravel() == k]
            proofs = prover.only(is_open[clause]).prove(*edge_motions(roadmap, prover.robot, these))
            free, blocked = these[proofs.free], these[~proofs.free]
            known[np.ix_(free, is_open)] = np.maximum(proofs.clearance[proofs.free], 0.0)[:, None]
            known[blocked, clause[proofs.pair[~proofs.free]]] = _BLOCKED
        return replace(self, known=known)

    def confirm(self, rows: Ints) -> EdgeProofs:
        """Return the proofs after a second checker found no contact on the edges ``rows``."""
        seen = np.array(self.seen)
        seen[rows] = True
        return replace(self, seen=seen)

    def refuse(self, row: int) -> EdgeProofs:
        """Return the proofs after a second checker found a contact on the proven edge ``row``."""
        known = np.array(self.known)
        known[row] = _BLOCKED
        return replace(self, known=known)


def _objects_of(world: World) -> dict[str, tuple[Obstacle | Carried, frozenset[frozenset[str]]]]:
    """Return obstacles and carried objects by name, each with its allowed contacts."""
    scene = world.scene
    items = (*scene.obstacles, *scene.carried)
    return {item.name: (item, frozenset(pair for pair in scene.allowed if item.object in pair)) for item in items}


def _measure_shift(before: tuple[Any, frozenset[Any]] | None, after: tuple[Any, frozenset[Any]] | None) -> float:
    """Return the largest displacement (m) of an object; infinite if it changed otherwise."""
    if before is None or after is None or before[1] != after[1]:
        return np.inf
    old, new = before[0], after[0]
    if old is new:
        return 0.0
    if isinstance(old, Carried) or isinstance(new, Carried) or old.shape is not new.shape:
        return np.inf
    return measure_displacement(old.shape, old.placement, new.placement)


def measure_displacement(shape: Shape, before: Floats, after: Floats) -> float:
    """Return the largest displacement (m) of a point of a shape between two placements (4, 4)."""
    points, radius = corners(shape)
    change = np.asarray(after) - np.asarray(before)
    # the norm of an affine map is convex, so its maximum over the hull is at a corner
    farthest = np.linalg.norm(points @ change[:3, :3].T + change[:3, 3], axis=1).max()
    return float(farthest + radius * np.linalg.norm(change[:3, :3], 2))


@lru_cache(maxsize=8)
def clauses_of(world: World) -> tuple[tuple[Clause, ...], Ints]:
    """Return the clauses of a world, and the clause of each of its pairs (pairs,)."""
    carried = {body.name for body in world.robot.carried}
    bodies = [body.name if body.name in carried else ARM for body in world.bodies]
    obstacles = [obstacle.name for obstacle in world.obstacles]
    named = [(body, obstacle) for body in bodies for obstacle in obstacles]
    named += [(min(bodies[i], bodies[k]), max(bodies[i], bodies[k])) for i, k in world.self_pairs]
    clauses = tuple(dict.fromkeys(named))
    number = {clause: k for k, clause in enumerate(clauses)}
    return clauses, np.array([number[clause] for clause in named], dtype=np.int64)


@dataclass(frozen=True, eq=False)
class LiveRoadmap:
    """A roadmap in the world of its ``checker``, with the proofs of its edges there.

    ``kept`` is the roadmap (None before the first query), with all edges ever proven; ``proofs`` are their current
    proofs. Its first ``lasting`` nodes stay, the others belong to queries. ``x`` (n,) is the field of the last query
    over its nodes.
    """

    checker: CollisionChecker
    proofs: EdgeProofs
    kept: Roadmap | None = None
    lasting: int = 0
    x: Floats = field(default_factory=lambda: np.zeros(0))

    @staticmethod
    def from_checker(checker: CollisionChecker) -> LiveRoadmap:
        """Return a live world without a roadmap."""
        return LiveRoadmap(checker, EdgeProofs.from_clearance(checker.world, np.zeros(0)))

    @property
    def roadmap(self) -> Roadmap:
        assert self.kept is not None  # callers check this
        return self.kept

    @property
    def world(self) -> World:
        return self.checker.world

    def with_roadmap(self, roadmap: Roadmap) -> LiveRoadmap:
        """Return this world with a roadmap that is proven in it."""
        proofs = EdgeProofs.from_clearance(self.world, roadmap.clearance + (roadmap.origin.margin - self.world.margin))
        n = len(roadmap.nodes)
        return replace(self, kept=roadmap, proofs=proofs, lasting=n, x=np.full(n, np.inf))

    def with_foreign_roadmap(self, roadmap: Roadmap) -> LiveRoadmap:
        """Return this world with a roadmap of the same joints, less the edges that are not proven here."""
        roadmap = reprove_in_other_world(roadmap, self.checker)
        return self.with_roadmap(check_nodes(restrict_to_constraints(roadmap, self.world.constraints), self.checker))

    def move_to_world(self, checker: CollisionChecker) -> LiveRoadmap:
        """Return the roadmap in the world of another ``checker``."""
        if checker is self.checker:
            return self
        kept = self.kept and replace(self.kept, checked_by=np.zeros(len(self.kept.nodes), dtype=np.int8))
        return replace(self, checker=checker, kept=kept, proofs=self.proofs.move_to_world(self.world, checker.world))

    def prove(self, rows: Ints) -> LiveRoadmap:
        """Prove the open clauses of the edges ``rows``."""
        if not len(rows):
            return self
        return replace(self, proofs=self.proofs.prove(EdgeProver(self.checker), self.roadmap, rows))

    def with_edges(self, edges: Bools) -> Roadmap:
        """Return the roadmap of all nodes and the selected ``edges`` (m,), with their current proofs."""
        clearance = np.maximum(np.nan_to_num(self.proofs.clearance, nan=0.0, posinf=np.inf), 0.0)
        complete = replace(
            self.roadmap,
            proven=self.proofs.free,
            clearance=clearance,
            origin=record_origin(self.checker, self.roadmap.origin.seed),
        )
        return complete.part(np.ones(len(complete.nodes), dtype=bool), edges)

    def enlarge(self, bigger: Roadmap) -> LiveRoadmap:
        """Add the new nodes and proven edges of ``bigger``, which grew from some edges of this roadmap."""
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
        """Return the roadmap with the nodes (n,) in ``keep`` and the edges between them."""
        edges: Bools = np.all(keep[self.roadmap.edges], axis=1)
        return replace(self, kept=self.roadmap.part(keep, edges), proofs=self.proofs.select(edges), x=self.x[keep])
