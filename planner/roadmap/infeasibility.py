"""The fewest known obstacles that separate the components of starts and goals of a roadmap.

That is the minimum constraint removal problem (Hauser 2014, "The minimum constraint removal problem with three robotics
applications"), which is NP-hard. Here the search uses straight motions between the components, each with the obstacles
that block it.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker, with_conditions
from planner.collision.edge_prover import EdgeProver
from planner.problem.outcome import BudgetSpent, ConstraintsTooNarrow, Gap, NoWay, Separated
from planner.roadmap.connections import find_nearest
from planner.roadmap.roadmap import Roadmap

_COMPONENTS = 12  # the largest components, from whose nodes links are tried, and those of starts and goals
_NEAREST = 4  # nodes of other components to which links from a node are tried
_LINKS = 1000  # the shortest links that are tried
_MOST_SETS = 20_000  # sets of obstacles that the search expands

Blockers = frozenset[int]
"""Numbers of obstacles in the scene."""


@dataclass(frozen=True, eq=False)
class _Links:
    """Straight motions between components, shortest first: node ``pairs`` (k, 2), joint ``length`` (k,)."""

    pairs: Ints
    length: Floats

    def take(self, rows: Ints | Bools) -> _Links:
        return _Links(self.pairs[rows], self.length[rows])


def explain_separation(roadmap: Roadmap, checker: CollisionChecker, progress: Progress = QUIET) -> NoWay:
    """Return the reason why the starts of a roadmap lie in other components than its goals.

    The named obstacles suffice: without them, and without path constraints, straight motions between the components
    that are proven free lead from a start to a goal. Fewer may suffice, as only some motions are tried. The result is
    meaningless after a stop of ``progress``.
    """
    gap, constraints = _gap(roadmap, checker), checker.world.constraints
    unconstrained = with_conditions(checker, ())
    links = _links(roadmap, unconstrained)
    fewest = _find_blockers(roadmap, links, _blockers(roadmap, unconstrained, links, progress))
    if fewest:
        return Separated(tuple(checker.world.obstacles[k].name for k in sorted(fewest)), gap)
    if constraints and fewest is not None:
        return ConstraintsTooNarrow(constraints.texts, gap)
    return BudgetSpent(len(roadmap.nodes), gap)


def _links(roadmap: Roadmap, checker: CollisionChecker) -> _Links:
    """Return motions from the nodes of the largest, the starts' and the goals' components to other ones."""
    labels = roadmap.components
    largest = np.argsort(-np.bincount(labels), kind="stable")[:_COMPONENTS]
    links = []
    for component in dict.fromkeys([*_ends(roadmap, labels), *largest.tolist()]):
        inside = labels == component
        links.append(_across(roadmap, checker, inside, ~inside))
    pairs = np.unique(np.sort(np.vstack([each.pairs for each in links]), axis=1), axis=0)
    length = _lengths(roadmap, checker, pairs)
    ends = np.isin(pairs, np.concatenate([roadmap.starts, roadmap.goals])).any(axis=1)
    order = np.lexsort((length, ~ends))[:_LINKS]  # a goal in a box has long links only
    return _Links(pairs[order], length[order])


def _across(roadmap: Roadmap, checker: CollisionChecker, inside: Bools, others: Bools) -> _Links:
    """Return motions from the nodes in one mask (n,) to the nearest of those in another, shortest first."""
    first, last = np.flatnonzero(inside), np.flatnonzero(others)
    if not len(first) or not len(last):
        return _Links(np.zeros((0, 2), dtype=np.int64), np.zeros(0))
    count = min(_NEAREST, len(last))
    length, rows = find_nearest(checker.robot, roadmap.nodes[last], roadmap.nodes[first], count)
    pairs = np.column_stack([np.repeat(first, count), last[rows.ravel()]])
    order = np.argsort(length.ravel(), kind="stable")
    return _Links(pairs[order], length.ravel()[order])


def _gap(roadmap: Roadmap, checker: CollisionChecker) -> Gap:
    """Return the shortest gap between the components of the starts and those of the goals."""
    sides = _sides(roadmap)
    nearest = _across(roadmap, checker, *sides).take(np.arange(1))
    (start,), (delta,) = _motions(roadmap, checker, nearest.pairs)
    proof = EdgeProver(checker).prove(start, delta)
    pair = None if proof.pair[0] < 0 else checker.world.contact(int(proof.pair[0]))
    between = None if pair is None else (pair.first, pair.second)
    return Gap(float(nearest.length[0]), tuple(start.tolist()), tuple((start + delta).tolist()), between)


def _blockers(roadmap: Roadmap, checker: CollisionChecker, links: _Links, progress: Progress) -> list[Blockers | None]:
    """Return for each link the obstacles that prevent its proof; None where the robot itself does."""
    world = checker.world
    motions = _motions(roadmap, checker, links.pairs)
    alone = _prover(checker, np.zeros(len(world.obstacles), dtype=bool), own=True).free(*motions)
    blocked = np.zeros((len(links.pairs), len(world.obstacles)), dtype=bool)
    for k in np.flatnonzero(world.checked.any(axis=0)):
        if progress.stopped:
            break
        prover = _prover(checker, np.arange(len(world.obstacles)) == k, own=False)
        blocked[alone, k] = ~prover.free(motions[0][alone], motions[1][alone])
    return [frozenset(np.flatnonzero(row).tolist()) if ok else None for row, ok in zip(blocked, alone, strict=True)]


def _find_blockers(roadmap: Roadmap, links: _Links, blockers: list[Blockers | None]) -> Blockers | None:
    """Return the fewest obstacles without which links join a start's component to a goal's, or None.

    Sets are expanded by size, without supersets of known sets of the same component: the first result is the smallest,
    unless ``_MOST_SETS`` were expanded.
    """
    labels = roadmap.components
    steps: dict[int, dict[int, list[Blockers]]] = {}
    for (i, j), obstacles in zip(labels[links.pairs].tolist(), blockers, strict=True):
        if obstacles is not None:
            for here, there in ((i, j), (j, i)):
                _add_minimal(steps.setdefault(here, {}).setdefault(there, []), obstacles)
    goals = set(labels[roadmap.goals].tolist())
    waiting = [(0, [], part) for part in dict.fromkeys(labels[roadmap.starts].tolist())]
    least: dict[int, list[Blockers]] = {}
    for _ in range(_MOST_SETS):
        if not waiting:
            return None
        _, members, part = heapq.heappop(waiting)
        blocked = frozenset(members)
        if part in goals:
            return blocked
        if not _add_minimal(least.setdefault(part, []), blocked):
            continue
        for other, ways in steps.get(part, {}).items():
            for way in ways:
                heapq.heappush(waiting, (len(blocked | way), sorted(blocked | way), other))
    return None


def _add_minimal(sets: list[Blockers], new: Blockers) -> bool:
    """Add ``new`` to ``sets`` unless it contains one of them, and remove its supersets.

    Returns whether it was added.
    """
    if any(known <= new for known in sets):
        return False
    sets[:] = [known for known in sets if not new <= known] + [new]
    return True


def _prover(checker: CollisionChecker, obstacles: Bools, own: bool) -> EdgeProver:
    """Return a prover for the world of the masked obstacles, with or without the robot's own pairs."""
    world = checker.world
    scene = world.checked & obstacles
    pairs = np.concatenate([scene.ravel(), np.full(len(world.self_pairs), own)])
    return EdgeProver(type(checker)(world.only(pairs)))


def _ends(roadmap: Roadmap, labels: Ints) -> list[int]:
    return labels[np.concatenate([roadmap.starts, roadmap.goals])].tolist()


def _sides(roadmap: Roadmap) -> tuple[Bools, Bools]:
    """Return the masks (n,) of the nodes that starts reach, and of those that reach goals."""
    labels = roadmap.components
    return np.isin(labels, labels[roadmap.starts]), np.isin(labels, labels[roadmap.goals])


def _motions(roadmap: Roadmap, checker: CollisionChecker, pairs: Ints) -> tuple[Floats, Floats]:
    """Return starts and motions (k, dof) between node ``pairs`` (k, 2)."""
    start = roadmap.nodes[pairs[:, 0]]
    return start, checker.robot.difference(start, roadmap.nodes[pairs[:, 1]])


def _lengths(roadmap: Roadmap, checker: CollisionChecker, pairs: Ints) -> Floats:
    return np.linalg.norm(_motions(roadmap, checker, pairs)[1], axis=1)
