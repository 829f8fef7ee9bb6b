"""The ladder of a tool path as a roadmap, alone or behind a free one, and its network, which leads forward only."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from planner import gabf
from planner.base.arrays import Bools, Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, Proofs
from planner.construction.build import origin_of
from planner.kinematics.manipulability import node_manipulability
from planner.kinematics.manipulability_proof import prove_floor
from planner.objective.scale import CostScale, measure_scale
from planner.planning.result import Plan
from planner.problem.request import PlanRequest
from planner.roadmap.measure import measure_edges
from planner.roadmap.node_checks import nobody
from planner.roadmap.roadmap import EDGE_ARRAYS, NODE_ARRAYS, Roadmap
from planner.tool_paths.ladder import Ladder


def ladder_roadmap(
    ladder: Ladder, checker: CollisionChecker, request: PlanRequest, progress: Progress = QUIET
) -> tuple[Roadmap | None, Floats]:
    """The ladder's motions that are free and above the floor, as far as they are joined to its first rungs.

    Its starts are the first rungs, its goals those farthest along the path that are reached.
    """
    robot, along, arcs = ladder.robot, ladder.along, ladder.arcs
    arcs = arcs[_on_the_way(along, arcs)]
    start = ladder.q[arcs[:, 0]]
    delta = robot.difference(start, ladder.q[arcs[:, 1]])
    proofs = EdgeProver(checker, progress).prove(start, delta, contacts=False)
    good = proofs.free
    if request.min_manipulability > 0:
        rows = np.flatnonzero(good)
        good[rows] = prove_floor(robot, np.stack([start, delta], axis=1)[rows], request.min_manipulability).holds
    arcs, rows = arcs[good], np.flatnonzero(good)
    kept = _on_the_way(along, arcs)
    if not kept.any():
        return None, np.zeros(0)
    return _roadmap(ladder, arcs[kept], proofs, rows[kept], checker, request.seed)


def _on_the_way(along: Floats, arcs: Ints) -> Bools:
    """(m,) the arcs that lie on a way from the path's beginning to what is farthest along it of all that is reached.

    Rungs are sorted along the path.
    """
    if not len(arcs):
        return np.zeros(0, dtype=bool)
    ahead = swept(along <= 1e-9, arcs)
    if not ahead[arcs[:, 0]].any():
        return np.zeros(len(arcs), dtype=bool)
    farthest = along[arcs[ahead[arcs[:, 0]], 1]].max()
    back = swept(ahead & (along >= farthest - 1e-9), arcs[:, ::-1])
    return ahead[arcs[:, 0]] & back[arcs[:, 1]]


def swept(reached: Bools, arcs: Ints) -> Bools:
    """(n,) what can be reached along arcs (m, 2) from where ``reached`` is True."""
    while True:
        more = reached.copy()
        more[arcs[reached[arcs[:, 0]], 1]] = True
        if (more == reached).all():
            return reached
        reached = more


def _roadmap(
    ladder: Ladder, arcs: Ints, proofs: Proofs, rows: Ints, checker: CollisionChecker, seed: int
) -> tuple[Roadmap, Floats]:
    used = np.unique(arcs)
    along = ladder.along[used]
    first, last = along <= 1e-9, along >= along.max() - 1e-9
    order = np.concatenate([np.flatnonzero(first), np.flatnonzero(last), np.flatnonzero(~first & ~last)])
    number = np.full(len(ladder.q), -1)
    number[used[order]] = np.arange(len(order))
    edges = np.sort(number[arcs], axis=1)
    sorted_ = np.lexsort((edges[:, 1], edges[:, 0]))
    nodes, edges, rows = ladder.q[used[order]], edges[sorted_], rows[sorted_]
    w, robot = node_manipulability(ladder.robot, nodes), ladder.robot
    unit = CostScale(1.0, 2.0, 1.0, 1.0, 0.01)
    measured = measure_edges(robot, nodes, edges, unit)
    scale = measure_scale(w, measured["joint_length"], measured["tool_length"])
    roadmap = Roadmap(
        nodes=nodes,
        edges=edges,
        proven=np.ones(len(edges), dtype=bool),
        starts=np.arange(first.sum()),
        goals=first.sum() + np.arange(last.sum()),
        manipulability=w,
        **measure_edges(robot, nodes, edges, scale),
        clearance=proofs.clearance[rows],
        samples=proofs.samples[rows],
        checked_by=nobody(len(nodes)),
        scale=scale,
        origin=origin_of(checker, seed),
    )
    return roadmap, along[order]


def roadmap_of_home(checker: CollisionChecker, request: PlanRequest) -> Roadmap:
    """A roadmap of the arm at home alone, for a path that is followed nowhere."""
    robot = checker.robot
    nodes, none = robot.home[None], np.zeros((0, 2), dtype=np.int64)
    w = node_manipulability(robot, nodes)
    scale = measure_scale(w, np.zeros(0), np.zeros(0))
    return Roadmap(
        nodes=nodes, edges=none, proven=np.zeros(0, bool), starts=np.zeros(1, np.int64), goals=np.zeros(0, np.int64),
        manipulability=w, **measure_edges(robot, nodes, none, scale), clearance=np.zeros(0),
        samples=np.zeros(0, np.int64), checked_by=nobody(1), scale=scale, origin=origin_of(checker, request.seed),
    )  # fmt: skip


def forward(network: gabf.Network, along: Floats) -> gabf.Network:
    """The network without the arcs that lead back along the path; off it ``along`` is -1."""
    tails, heads = along[network.tails], along[network.indices]
    return network.without_arcs(np.flatnonzero((tails > heads) & (tails > 1e-9)))


def joined(free: Plan, ladder: Roadmap, along: Floats) -> tuple[Roadmap, Floats]:
    """The free roadmap with the ladder behind its goals, on its scale; the ladder's other first rungs are left out."""
    robot, roadmap = free.robot, free.roadmap
    roomy = roadmap.part(np.ones(len(roadmap.nodes), bool), roadmap.clearance >= free.clearance_kept)
    roadmap = roomy if roomy.connected else roadmap
    n = len(roadmap.nodes)
    number = np.where(along > 1e-9, n + np.cumsum(along > 1e-9) - 1, -1)
    for goal in roadmap.goals:
        same = np.abs(ladder.nodes[ladder.starts] - roadmap.nodes[goal]).max(axis=1) < 1e-9
        number[ladder.starts[same]] = goal
    kept = (number >= 0)[ladder.edges].all(axis=1)
    edges = np.sort(number[ladder.edges[kept]], axis=1)
    behind = along > 1e-9
    rungs = {name: getattr(ladder, name)[behind] for name in NODE_ARRAYS}
    nodes = {name: np.concatenate([getattr(roadmap, name), rungs[name]]) for name in NODE_ARRAYS}
    arcs: dict[str, Any] = {name: getattr(ladder, name)[kept] for name in EDGE_ARRAYS} | {"edges": edges}
    arcs |= measure_edges(robot, nodes["nodes"], edges, roadmap.scale)
    joined = {name: np.concatenate([getattr(roadmap, name), arcs[name]]) for name in EDGE_ARRAYS}
    order = np.lexsort((joined["edges"][:, 1], joined["edges"][:, 0]))
    joined = {name: array[order] for name, array in joined.items()}
    places = np.concatenate([np.full(n, -1.0), along[behind]])
    places[roadmap.goals] = 0.0
    return replace(roadmap, **nodes, **joined, goals=number[ladder.goals]), places
