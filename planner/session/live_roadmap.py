"""A roadmap in a world that changes: what was ever proven stays, and is proven again where a change concerns it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.collision.world import World
from planner.roadmap.measure import nobody, with_checked_nodes
from planner.roadmap.obtain import in_this_world
from planner.roadmap.roadmap import EDGE_ARRAYS, NODE_ARRAYS, Roadmap, kept_part, origin_of
from planner.session.edge_proofs import EdgeProofs


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
    def of(checker: CollisionChecker) -> LiveRoadmap:
        """No roadmap yet."""
        return LiveRoadmap(checker, EdgeProofs.of(checker.world, np.zeros(0)))

    @property
    def roadmap(self) -> Roadmap:
        assert self.kept is not None  # callers check this
        return self.kept

    @property
    def world(self) -> World:
        return self.checker.world

    @cached_property
    def prover(self) -> EdgeProver:
        return EdgeProver(self.checker)

    def with_roadmap(self, roadmap: Roadmap) -> LiveRoadmap:
        """With a roadmap that is proven in this very world."""
        proofs = EdgeProofs.of(self.world, roadmap.clearance + (roadmap.origin.margin - self.world.margin))
        n = len(roadmap.nodes)
        return replace(self, kept=roadmap, proofs=proofs, lasting=n, x=np.full(n, np.inf))

    def with_foreign_roadmap(self, roadmap: Roadmap) -> LiveRoadmap:
        """With a roadmap of the same joints in any world, as far as it holds in this one."""
        roadmap = in_this_world(roadmap, self.checker)
        return self.with_roadmap(with_checked_nodes(kept_part(roadmap, self.world.keeps), self.checker))

    def in_world(self, checker: CollisionChecker) -> LiveRoadmap:
        """The same roadmap in the world of another ``checker``."""
        if checker is self.checker:
            return self
        kept = None if self.kept is None else replace(self.kept, checked_by=nobody(len(self.kept.nodes)))
        return replace(self, checker=checker, kept=kept, proofs=self.proofs.in_world(self.world, checker.world))

    def proven(self, rows: Ints) -> LiveRoadmap:
        """After a proof of what is open of the edges ``rows``."""
        return replace(self, proofs=self.proofs.proven(self.prover, self.roadmap, rows)) if len(rows) else self

    def held(self, edges: Bools) -> Roadmap:
        """The roadmap of all nodes and of some ``edges`` (m,), with what is known of these now."""
        clearance = np.maximum(np.nan_to_num(self.proofs.clearance, nan=0.0, posinf=np.inf), 0.0)
        whole = replace(
            self.roadmap,
            proven=self.proofs.free,
            clearance=clearance,
            origin=origin_of(self.checker, self.roadmap.origin.seed),
        )
        return whole.part(np.ones(len(whole.nodes), dtype=bool), edges)

    def enlarged(self, bigger: Roadmap) -> LiveRoadmap:
        """With what a roadmap that grew from a part of this one has more: nodes after ours, edges proven just now."""
        n, old = len(bigger.nodes), self.roadmap
        mine, theirs = (edges[:, 0] * n + edges[:, 1] for edges in (old.edges, bigger.edges))
        known_free = mine[self.proofs.free | self.proofs.open]
        fresh = ~np.isin(theirs, known_free)
        kept = ~np.isin(mine, theirs[fresh])
        whole = {name: np.concatenate([getattr(old, name)[kept], getattr(bigger, name)[fresh]]) for name in EDGE_ARRAYS}
        order = np.argsort(np.concatenate([mine[kept], theirs[fresh]]), kind="stable")
        new = EdgeProofs.of(self.world, bigger.clearance[fresh])
        arrays = {name: array[order] for name, array in whole.items()}
        nodes = {name: getattr(bigger, name) for name in NODE_ARRAYS}
        roadmap = replace(old, starts=bigger.starts, goals=bigger.goals, **nodes, **arrays)
        x = np.concatenate([self.x, np.full(n - len(self.x), np.inf)])
        return replace(self, kept=roadmap, proofs=self.proofs.rows(kept).followed_by(new).rows(order), x=x)

    def without_nodes(self, keep: Bools) -> LiveRoadmap:
        """With the nodes (n,) in ``keep`` and the edges between them only."""
        edges: Bools = np.all(keep[self.roadmap.edges], axis=1)
        return replace(self, kept=self.roadmap.part(keep, edges), proofs=self.proofs.rows(edges), x=self.x[keep])
