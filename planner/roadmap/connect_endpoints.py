"""New starts and goals on an existing roadmap, linked by proven edges; the roadmap grows only if it must."""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.query.resolve import free_configurations
from planner.roadmap.connections import NEIGHBOURS
from planner.roadmap.edge_certificates import RecordingProver
from planner.roadmap.enlarge import enlarged
from planner.roadmap.forest import Forest
from planner.roadmap.growth_settings import GrowthSettings
from planner.roadmap.roadmap import Roadmap, component_labels
from planner.roadmap.shortcuts import Linked, shortcuts, straight_paths
from planner.roadmap.straight_motions import Motions

SAME = 1e-9  # rad: a configuration this near a node is that node
_FIRST = 10  # neighbours that a new end is linked to: every proof takes time from a query
_WAY_NEIGHBOURS = 5  # links tried from each new node of a path that had to be grown

_log = logging.getLogger(__name__)


def attach(
    roadmap: Roadmap,
    checker: CollisionChecker,
    starts: Floats,
    goals: Floats,
    seed: int = 0,
    settings: GrowthSettings | None = None,
    progress: Progress = QUIET,
    join: bool = True,
) -> Roadmap:
    """The roadmap with ``starts`` (s, dof) and ``goals`` (g, dof) as its starts and goals.

    Those that are not nodes yet become nodes, linked to their nearest neighbours and by straight motions from start to
    goal, wherever that is proven. Where a start is then still disconnected from every goal, RRTConnect grows a path
    between them and the largest component: at most ``settings.join_motions`` motions per try; with ``join`` False
    nothing grows. Then the best paths get proven shortcuts past their waypoints. The cost scale stays: costs mean the
    same as before. One roadmap serves many starts: one field over it answers all of them. Raises :class:`StateError`
    for an end that is not free.
    """
    settings = settings or GrowthSettings()

    def find_bridges(prover: RecordingProver, part: Floats, other: Floats) -> list[Floats]:
        from planner.roadmap.bridges import bridges  # which loads OMPL: few queries need it

        return bridges(prover, part, other, seed, settings, progress)

    builder = _Builder(roadmap, checker, find_bridges, progress)
    ends = free_configurations([*(("start", q) for q in starts), *(("goal", q) for q in goals)], checker)
    first, last = np.split(np.array([builder.index(q) for q in ends], dtype=np.int64), [len(starts)])
    same = np.array_equal(first, roadmap.starts) and np.array_equal(last, roadmap.goals)
    if same and (roadmap.connected or not join):
        return roadmap
    builder.link(np.arange(len(roadmap.nodes), len(builder.nodes)), NEIGHBOURS)
    builder.link_straight(first, last, settings.range)
    for start in dict.fromkeys(first.tolist() if join else ()):
        builder.bring_together(start, last)
    n, m = len(roadmap.nodes), len(roadmap.edges)
    linked = Linked(roadmap, builder.nodes[n:], builder.edges[m:], first, last)
    found = shortcuts(linked, builder.prover, settings.range, progress)
    edges = np.concatenate([linked.added_edges, found.edges()])
    return enlarged(roadmap, builder.prover, found.nodes()[n:], edges, (first, last))


class _Builder:
    """The roadmap's nodes and edges, and what is added to them."""

    def __init__(
        self,
        roadmap: Roadmap,
        checker: CollisionChecker,
        find_bridges: Callable[[RecordingProver, Floats, Floats], list[Floats]],
        progress: Progress,
    ) -> None:
        self.robot, self.prover = checker.robot, RecordingProver(checker, progress)
        self.find_bridges, self.progress = find_bridges, progress
        self.roadmap, self.nodes, self.edges = roadmap, roadmap.nodes, roadmap.edges
        self._apart: dict[int, Floats] = {}  # of an end that became a node, from those before it

    def index(self, q: Floats) -> int:
        """The node at ``q``, added if there is none."""
        apart = np.linalg.norm(self.robot.difference(q, self.nodes), axis=1)
        nearest, new = int(np.argmin(apart)), len(self.nodes)
        if apart[nearest] <= SAME:
            return nearest
        self.nodes, self._apart[new] = np.vstack([self.nodes, q]), apart
        return new

    def link(self, new: Ints, count: int) -> None:
        """Link each of the ``new`` nodes to those before it that are nearest, wherever that is proven.

        The nearest ``_FIRST`` are tried, and up to ``count`` where none of these can be reached.
        """
        near = {int(node): self._nearest(node, count) for node in new}
        for tried in (slice(0, _FIRST), slice(_FIRST, count)):
            pairs = [np.column_stack([rows[tried], np.full(len(rows[tried]), node)]) for node, rows in near.items()]
            if not pairs:
                break
            edges = np.concatenate(pairs)
            a, b = self.nodes[edges[:, 1]], self.nodes[edges[:, 0]]
            delta = self.robot.difference(a, b)
            edges = edges[self.prover.free(a, delta) & self.robot.told_by_ends(delta)]
            self._add(edges)
            near = {node: rows for node, rows in near.items() if node not in edges[:, 1]}

    def _nearest(self, node: int, count: int) -> Ints:
        """The nodes before ``node`` that are nearest to it, nearest first."""
        apart = self._apart.get(node)
        if apart is None:
            apart = np.linalg.norm(self.robot.difference(self.nodes[node], self.nodes[:node]), axis=1)
        if len(apart) <= count:
            return np.argsort(apart, kind="stable")
        near = np.flatnonzero(apart <= np.partition(apart, count)[count])
        return near[np.argsort(apart[near], kind="stable")[:count]]

    def link_straight(self, starts: Ints, goals: Ints, longest: float) -> None:
        """Add the straight motions from ``starts`` to ``goals`` that are proven, in pieces."""
        self._add_paths(straight_paths(Motions(self.prover), self.nodes[starts], self.nodes[goals], longest))

    def bring_together(self, start: int, goals: Ints) -> None:
        """Grow until ``start`` and one of the ``goals`` are joined, through the largest component if that helps."""
        if not len(goals) or self._reaches(start, goals):
            return
        before, labels = len(self.nodes), self._labels()
        main = labels == np.argmax(np.bincount(labels))
        at_main = bool(main[start]) or self._join(main, labels == labels[start])
        if not self._reaches(start, goals):
            labels = self._labels()
            mine = labels == labels[start]
            theirs = np.isin(labels, labels[goals]) & ~mine
            self._join(mine, theirs if at_main else theirs & ~main)  # the largest was tried without result
        more = len(self.nodes) - before
        if self._reaches(start, goals):
            _log.warning("direct links did not join start and goal: the roadmap grew by %d nodes to join them", more)
        else:
            _log.warning("neither direct links nor %d nodes more joined start and goal", more)

    def _join(self, one: Bools, other: Bools) -> bool:
        """Bridge the nodes in one mask (n,) and those in another, and link what is new; whether a bridge was found."""
        if self.progress.stopped or not other.any():
            return False
        n = len(self.nodes)
        found = self.find_bridges(self.prover, self.nodes[one], self.nodes[other])
        if found:
            self._add_paths(found)
            self.link(np.arange(n, len(self.nodes)), _WAY_NEIGHBOURS)
        return bool(found)

    def _add_paths(self, paths: list[Floats]) -> None:
        """Add proven paths; those ends that are nodes already stay these nodes."""
        if not paths:
            return
        forest = Forest(self.nodes)
        for path in paths:
            forest.add_path(path)
        self.nodes = forest.nodes()
        self._add(forest.edges())

    def _add(self, edges: Ints) -> None:
        self.edges = np.concatenate([self.edges, edges])

    def _labels(self) -> Ints:
        """(n,) component numbers: those of the roadmap, joined by the edges that were added."""
        known, more = self.roadmap.component_count, len(self.nodes) - len(self.roadmap.nodes)
        before = np.concatenate([self.roadmap.components, known + np.arange(more)])
        return component_labels(known + more, before[self.edges[len(self.roadmap.edges) :]])[before]

    def _reaches(self, start: int, goals: Ints) -> bool:
        labels = self._labels()
        return bool((labels[goals] == labels[start]).any())
