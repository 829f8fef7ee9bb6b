"""New starts and goals on a roadmap, linked by proven edges; it grows only where they need a bridge."""

import logging
from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver
from planner.query.resolve import free_configurations
from planner.roadmap.connections import NEIGHBOURS, find_nearest
from planner.roadmap.edges import MotionChecker, RecordingProver, enlarge_roadmap
from planner.roadmap.first_path import FirstPathSearch
from planner.roadmap.forest import Forest
from planner.roadmap.grow import GrowthSettings, join_settings
from planner.roadmap.roadmap import Roadmap, component_labels
from planner.roadmap.shortcuts import DraftRoadmap, prove_shortcuts, prove_straight_paths, split_motions
from planner.robot.robot import Robot

SAME = 1e-9  # rad: a configuration this near to a node is that node

_BRIDGE_NEIGHBOURS = 5  # links tried from each new node of a bridge

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
    """Return the roadmap with ``starts`` (s, dof) and ``goals`` (g, dof) as its starts and goals.

    Those that are not nodes yet become nodes, linked to their nearest neighbours and by straight motions from start to
    goal, wherever that is proven. Where a start is then still disconnected from every goal, RRTConnect grows a path
    between them and the largest component: at most ``settings.join_motions`` motions per try; with ``join`` False
    nothing grows. Then the best paths get proven shortcuts past their waypoints. The cost scale stays, so costs remain
    comparable. One roadmap serves many starts: one field over it answers all of them. Raises :class:`StateError` for an
    end that is not free.
    """
    settings = settings or GrowthSettings()

    builder = _Builder(roadmap, checker, seed, settings, progress)
    ends = free_configurations([*(("start", q) for q in starts), *(("goal", q) for q in goals)], checker)
    first, last = np.split(np.array([builder.index(q) for q in ends], dtype=np.int64), [len(starts)])
    same = np.array_equal(first, roadmap.starts) and np.array_equal(last, roadmap.goals)
    if same and (roadmap.is_connected or not join):
        return roadmap
    builder.link(np.arange(len(roadmap.nodes), len(builder.nodes)), NEIGHBOURS)
    builder.link_straight(first, last, settings.range)
    for start in dict.fromkeys(first.tolist() if join else ()):
        builder.join_to_goals(start, last)
    n, m = len(roadmap.nodes), len(roadmap.edges)
    linked = DraftRoadmap(roadmap, builder.nodes[n:], builder.edges[m:], first, last)
    forest = prove_shortcuts(linked, builder.prover, settings.range, progress)
    edges = np.concatenate([linked.added_edges, forest.edges()])
    return enlarge_roadmap(roadmap, builder.prover, forest.nodes()[n:], edges, (first, last))


class _Builder:
    """The nodes and edges of a roadmap, and the additions to them."""

    def __init__(
        self,
        roadmap: Roadmap,
        checker: CollisionChecker,
        seed: int,
        settings: GrowthSettings,
        progress: Progress,
    ) -> None:
        self.robot, self.prover = checker.robot, RecordingProver(checker, progress)
        self.seed, self.settings, self.progress = seed, settings, progress
        self.roadmap, self.nodes, self.edges = roadmap, roadmap.nodes, roadmap.edges
        self._distances: dict[int, Floats] = {}  # from an end that became a node to the nodes before it

    def index(self, q: Floats) -> int:
        """Return the number of the node at ``q``; add it if it is new."""
        apart = np.linalg.norm(self.robot.difference(q, self.nodes), axis=1)
        nearest, new = int(np.argmin(apart)), len(self.nodes)
        if apart[nearest] <= SAME:
            return nearest
        self.nodes, self._distances[new] = np.vstack([self.nodes, q]), apart
        return new

    def link(self, new: Ints, count: int) -> None:
        """Link each of the ``new`` nodes to the ``count`` nearest nodes before it, wherever that is proven."""
        near = [(node, self._nearest(node, count)) for node in new.tolist()]
        edges = np.array([(row, node) for node, rows in near for row in rows], dtype=np.int64).reshape(-1, 2)
        a, b = self.nodes[edges[:, 1]], self.nodes[edges[:, 0]]
        delta = self.robot.difference(a, b)
        self._add(edges[self.prover.free(a, delta) & self.robot.is_below_half_turn(delta)])

    def _nearest(self, node: int, count: int) -> Ints:
        """Return the nodes before ``node`` that are nearest to it, nearest first."""
        apart = self._distances.get(node)
        if apart is None:
            apart = np.linalg.norm(self.robot.difference(self.nodes[node], self.nodes[:node]), axis=1)
        if len(apart) <= count:
            return np.argsort(apart, kind="stable")
        near = np.flatnonzero(apart <= np.partition(apart, count)[count])
        return near[np.argsort(apart[near], kind="stable")[:count]]

    def link_straight(self, starts: Ints, goals: Ints, longest: float) -> None:
        """Add the proven straight motions from ``starts`` to ``goals``, split at ``longest`` (rad)."""
        self._add_paths(
            prove_straight_paths(MotionChecker(self.prover), self.nodes[starts], self.nodes[goals], longest)
        )

    def join_to_goals(self, start: int, goals: Ints) -> None:
        """Grow until ``start`` and one of the ``goals`` are joined, through the largest component if it helps."""
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
            _log.warning("neither direct links nor %d more nodes joined start and goal", more)

    def _join(self, one: Bools, other: Bools) -> bool:
        """Bridge the nodes in one mask (n,) and those in another, and link new nodes; return the success."""
        if self.progress.stopped or not other.any():
            return False
        n = len(self.nodes)
        one_side, other_side = self.nodes[one], self.nodes[other]
        paths = grow_bridges(self.prover, one_side, other_side, self.seed, self.settings, self.progress)
        if paths:
            self._add_paths(paths)
            self.link(np.arange(n, len(self.nodes)), _BRIDGE_NEIGHBOURS)
        return bool(paths)

    def _add_paths(self, paths: list[Floats]) -> None:
        """Add proven paths; ends that are nodes already stay these nodes."""
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
        """Return (n,) component numbers: those of the roadmap, merged by the added edges."""
        known, more = self.roadmap.component_count, len(self.nodes) - len(self.roadmap.nodes)
        before = np.concatenate([self.roadmap.components, known + np.arange(more)])
        return component_labels(known + more, before[self.edges[len(self.roadmap.edges) :]])[before]

    def _reaches(self, start: int, goals: Ints) -> bool:
        labels = self._labels()
        return bool((labels[goals] == labels[start]).any())


_PER_NODE = 4  # nodes of the other part, the nearest ones, that each node is paired with
_FIRST, _MOST = 32, 1024  # pairs proven together, twice as many each time, and pairs proven at most


def grow_bridges(
    prover: EdgeProver,
    part: Floats,
    other: Floats,
    seed: int = 0,
    settings: GrowthSettings | None = None,
    progress: Progress = QUIET,
) -> list[Floats]:
    """Return paths (k, dof) of proven motions between nodes ``part`` (n, dof) and ``other`` (m, dof).

    Pairs of near nodes are proven, the shortest first, until some are free: these are the result. Where none of
    ``_MOST`` is, RRTConnect searches near the shortest pair, then everywhere from all nodes at once, with the counts of
    ``settings``. No motion is longer than ``settings.range``. Empty where nothing succeeds. The same seed gives the
    same paths.
    """
    robot, settings = prover.robot, settings or GrowthSettings()
    pairs = _near_pairs(robot, part, other)
    for ends in _batches(pairs):
        free = prover.free(ends[:, 0], robot.difference(ends[:, 0], ends[:, 1]))
        if free.any() or progress.stopped:
            return [split_motions(prover, pair, settings.range) for pair in ends[free]]
    rng = np.random.default_rng(seed)
    search = FirstPathSearch(MotionChecker(prover), join_settings(settings, robot), rng, progress)
    path = search.join_near(part, other, pairs[0]) if len(pairs) else None
    if path is None:
        path = search.join(part, other)
    return [] if path is None else [path]


def _near_pairs(robot: Robot, part: Floats, other: Floats) -> Floats:
    """Return ends (k, 2, dof) of straight motions between near nodes of both sets, the shortest first."""
    if not (len(part) and len(other)):
        return np.zeros((0, 2, robot.dof))
    swapped = len(part) < len(other)
    many, few = (other, part) if swapped else (part, other)
    length, row = find_nearest(robot, many, few, min(_PER_NODE, len(many)))
    order = np.argsort(length, axis=None, kind="stable")[:_MOST]
    ends = few[order // length.shape[1]], many[row.ravel()[order]]
    return np.stack(ends if swapped else ends[::-1], axis=1)


def _batches(pairs: Floats) -> Iterator[Floats]:
    """Yield the pairs in order, ``_FIRST`` of them and then twice as many each time."""
    begin, size = 0, _FIRST
    while begin < len(pairs):
        yield pairs[begin : begin + size]
        begin, size = begin + size, 2 * size
