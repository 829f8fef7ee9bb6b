"""New starts and goals on a roadmap that is already there, through proven edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planner.arrays import Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.collision.edges import EdgeProver
from planner.roadmap.build import measured
from planner.roadmap.connect import NEIGHBOURS
from planner.roadmap.roadmap import Roadmap

SAME = 1e-9  # rad: a configuration this near a node is that node


def attach(roadmap: Roadmap, checker: CollisionChecker, starts: Floats, goals: Floats) -> Roadmap:
    """The roadmap with ``starts`` (s, dof) and ``goals`` (g, dof) as its starts and goals.

    Those that are not nodes yet become nodes, linked to their nearest neighbours wherever that is proven. The
    cost scale stays: costs mean the same as before.
    """
    builder = _Builder(roadmap, checker)
    first = [builder.index(q) for q in starts]
    last = [builder.index(q) for q in goals]
    return builder.finish(np.array(first, dtype=np.int64), np.array(last, dtype=np.int64))


class _Builder:
    def __init__(self, roadmap: Roadmap, checker: CollisionChecker) -> None:
        self.roadmap, self.checker, self.robot = roadmap, checker, checker.world.robot
        self.prover = EdgeProver(checker)
        self.nodes, self.edges = roadmap.nodes, roadmap.edges

    def index(self, q: Floats) -> int:
        """The node at ``q``, added and linked if there is none."""
        delta = self.robot.difference(q, self.nodes)
        apart = np.linalg.norm(delta, axis=1)
        nearest = int(np.argmin(apart))
        if apart[nearest] <= SAME:
            return nearest
        near = np.argsort(apart, kind="stable")[:NEIGHBOURS]
        free = near[self.prover.prove(np.repeat(q[None], len(near), axis=0), delta[near]).free]
        new = len(self.nodes)
        self.nodes = np.vstack([self.nodes, q])
        self.edges = np.vstack([self.edges, np.column_stack([free, np.full(len(free), new)])])
        return new

    def finish(self, starts: Ints, goals: Ints) -> Roadmap:
        """The roadmap with what was added: an unproven edge stays unproven, and the margin is the weakest proof's."""
        old = self.roadmap
        order = np.lexsort((self.edges[:, 1], self.edges[:, 0]))
        proven = np.concatenate([old.proven, np.ones(len(self.edges) - len(old.edges), dtype=bool)])
        origin = replace(old.origin, margin=min(old.origin.margin, self.checker.world.margin))
        new = measured(self.checker, self.nodes, self.edges[order], starts, goals, origin, lambda *_: old.scale)
        return replace(new, proven=proven[order])
