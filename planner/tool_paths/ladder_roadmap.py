"""The ladder of a tool path as a roadmap, alone or behind a free one, and its network, which leads forward only."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Proofs
from planner.cost.scale import CostScale, measure_scale
from planner.kinematics.manipulability import node_manipulability, prove_floor
from planner.native.graphs import reached
from planner.roadmap.measure import measure_edges, nobody
from planner.roadmap.roadmap import EDGE_ARRAYS, NODE_ARRAYS, Roadmap, origin_of
from planner.robot.robot import Robot
from planner.tool_paths.ladder import Ladder

NEW, LEFT_OUT = -1, -2  # what becomes of a ladder's nodes


@dataclass(frozen=True, eq=False)
class Reached:
    """What of a ``ladder`` is joined to its first rungs by motions that are free and above a floor.

    The starts of ``roadmap`` are these, its goals the rungs farthest along the path; None without any such motion.
    ``along`` (n,): where its nodes are, m along the path.
    """

    ladder: Ladder
    roadmap: Roadmap | None = None
    along: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def share(self) -> float:
        """Of the path's length."""
        return float(self.along.max() / self.ladder.stations[-1]) if self.roadmap else 0.0

    @property
    def whole(self) -> bool:
        """Whether it leads to the end."""
        return self.share >= 1.0 - 1e-9

    @property
    def ends(self) -> Floats:
        """(k, dof) as far as it comes; none where it does not begin."""
        return self.roadmap.nodes[self.roadmap.goals] if self.roadmap else self.ladder.q[:0]


def reached_on(
    ladder: Ladder, checker: CollisionChecker, floor: float, seed: int, progress: Progress = QUIET
) -> Reached:
    """The ladder's motions that are free and above a ``floor``, as far as they lead on from its begin."""
    robot, along, arcs = ladder.robot, ladder.along, ladder.arcs
    arcs = arcs[_on_the_way(along, arcs)]
    start = ladder.q[arcs[:, 0]]
    delta = robot.difference(start, ladder.q[arcs[:, 1]])
    proofs = EdgeProver(checker, progress).prove(start, delta, contacts=False)
    good = proofs.free
    if floor > 0:
        rows = np.flatnonzero(good)
        good[rows] = prove_floor(robot, np.stack([start, delta], axis=1)[rows], floor).holds
    arcs, rows = arcs[good], np.flatnonzero(good)
    kept = _on_the_way(along, arcs)
    if not kept.any():
        return Reached(ladder)
    return _roadmap(ladder, arcs[kept], proofs, rows[kept], checker, seed)


def _on_the_way(along: Floats, arcs: Ints) -> Bools:
    """(m,) the arcs that lie on a way from the path's beginning to what is farthest along it of all that is reached.

    Rungs are sorted along the path.
    """
    if not len(arcs):
        return np.zeros(0, dtype=bool)
    ahead = reached(along <= 1e-9, arcs)
    if not ahead[arcs[:, 0]].any():
        return np.zeros(len(arcs), dtype=bool)
    farthest = along[arcs[ahead[arcs[:, 0]], 1]].max()
    back = reached(ahead & (along >= farthest - 1e-9), arcs[:, ::-1])
    return ahead[arcs[:, 0]] & back[arcs[:, 1]]


def _roadmap(ladder: Ladder, arcs: Ints, proofs: Proofs, rows: Ints, checker: CollisionChecker, seed: int) -> Reached:
    used = np.unique(arcs)
    along = ladder.along[used]
    first, last = along <= 1e-9, along >= along.max() - 1e-9
    order = np.concatenate([np.flatnonzero(first), np.flatnonzero(last), np.flatnonzero(~first & ~last)])
    number = np.full(len(ladder.q), -1)
    number[used[order]] = np.arange(len(order))
    edges = np.sort(number[arcs], axis=1)
    sorted_ = np.lexsort((edges[:, 1], edges[:, 0]))
    ends = np.arange(first.sum()), first.sum() + np.arange(last.sum())
    rows = rows[sorted_]
    free = np.maximum(proofs.clearance[rows], 0.0), proofs.samples[rows]
    return Reached(ladder, _made(checker, seed, ladder.q[used[order]], ends, edges[sorted_], *free), along[order])


def roadmap_of(checker: CollisionChecker, nodes: Floats, seed: int) -> Roadmap:
    """A roadmap of ``nodes`` (n, dof) alone, the first of them its start, for what is followed nowhere."""
    none = np.zeros(0, dtype=np.int64)
    return _made(checker, seed, nodes, (np.zeros(1, np.int64), none), np.zeros((0, 2), np.int64), np.zeros(0), none)


def _made(
    checker: CollisionChecker,
    seed: int,
    nodes: Floats,
    ends: tuple[Ints, Ints],
    edges: Ints,
    clearance: Floats,
    samples: Ints,
) -> Roadmap:
    """The roadmap of proven edges, on a scale of its own."""
    robot, w = checker.robot, node_manipulability(checker.robot, nodes)
    measured = measure_edges(robot, nodes, edges, CostScale(1.0, 2.0, 1.0, 1.0, 0.01))
    scale = measure_scale(w, measured["joint_length"], measured["tool_length"])
    return Roadmap(
        nodes=nodes, edges=edges, proven=np.ones(len(edges), dtype=bool), starts=ends[0], goals=ends[1],
        manipulability=w, **measure_edges(robot, nodes, edges, scale), clearance=clearance, samples=samples,
        checked_by=nobody(len(nodes)), scale=scale, origin=origin_of(checker, seed),
    )  # fmt: skip


def attached(robot: Robot, roadmap: Roadmap, ladder: Roadmap, number: Ints) -> tuple[Roadmap, Ints]:
    """The roadmap with the nodes of a ladder behind its own, on its scale, and the number (n,) that each has there.

    ``number`` (n,) says which are the roadmap's own, by their numbers; NEW are the others, and LEFT_OUT those that are
    not taken.
    """
    n, new = len(roadmap.nodes), number == NEW
    number = np.where(new, n + np.cumsum(new) - 1, number)
    kept = (number >= 0)[ladder.edges].all(axis=1)
    edges = np.sort(number[ladder.edges[kept]], axis=1)
    nodes = {name: np.concatenate([getattr(roadmap, name), getattr(ladder, name)[new]]) for name in NODE_ARRAYS}
    arcs: dict[str, Any] = {name: getattr(ladder, name)[kept] for name in EDGE_ARRAYS} | {"edges": edges}
    arcs |= measure_edges(robot, nodes["nodes"], edges, roadmap.scale)
    joined = {name: np.concatenate([getattr(roadmap, name), arcs[name]]) for name in EDGE_ARRAYS}
    order = np.lexsort((joined["edges"][:, 1], joined["edges"][:, 0]))
    return replace(roadmap, **nodes, **{name: array[order] for name, array in joined.items()}), number
