"""The ladder of a tool path as a roadmap, alone or behind a free one, and why it leads no farther."""

from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker, contact_at
from planner.collision.edge_prover import EdgeProver
from planner.constraints.floor import prove_floor
from planner.cost.scale import CostScale, measure_scale
from planner.kinematics.inverse import POSITION_TOLERANCE
from planner.kinematics.manipulability import node_manipulability
from planner.native.graphs import reachable
from planner.problem.outcome import CannotFollow
from planner.roadmap.measure import measure_edges, unchecked
from planner.roadmap.roadmap import EDGE_ARRAYS, NODE_ARRAYS, Roadmap, record_origin
from planner.robot.robot import Robot
from planner.tool_paths.ladder import Ladder, solutions_at
from planner.tool_paths.tube import Tube

NEW, LEFT_OUT = -1, -2  # what becomes of a ladder's nodes
_STARTS = 300  # descents at a place that a reason is given for
_CONES = (0.0, 0.05, 0.1, 0.2, 0.4, 0.8)  # rad
_LOOKED_AT = 40  # solutions whose contacts are named


@dataclass(frozen=True, eq=False)
class LadderProgress:
    """What of a ``ladder`` is joined to its first rungs by motions that are free and above a floor.

    The starts of ``roadmap`` are these, its goals the rungs farthest along the path; without any such motion it is the
    robot's home alone, and has no goal. ``along`` (n,): where its nodes are, m along the path.
    """

    ladder: Ladder
    roadmap: Roadmap
    along: Floats

    @property
    def share(self) -> float:
        """Of the path's length."""
        return float(self.along.max() / self.ladder.stations[-1])

    @property
    def whole(self) -> bool:
        """Whether it leads to the end."""
        return self.share >= 1.0 - 1e-9

    @property
    def ends(self) -> Floats:
        """(k, dof) as far as it comes; none where it does not begin."""
        return self.roadmap.nodes[self.roadmap.goals]


def follow_ladder(
    ladder: Ladder, checker: CollisionChecker, floor: float, seed: int, progress: Progress = QUIET
) -> LadderProgress:
    """The ladder's motions that are free and above a ``floor``, as far as they lead on from its begin."""
    robot, along, arcs = ladder.robot, ladder.along, ladder.arcs
    arcs = arcs[_on_the_way(along, arcs)]
    start = ladder.q[arcs[:, 0]]
    delta = robot.difference(start, ladder.q[arcs[:, 1]])
    proofs = EdgeProver(checker, progress, "proofs").prove(start, delta, contacts=False)
    good = proofs.free
    if floor > 0:
        rows = np.flatnonzero(good)
        good[rows] = prove_floor(robot, np.stack([start, delta], axis=1)[rows], floor).holds
    arcs, rows = arcs[good], np.flatnonzero(good)
    kept = _on_the_way(along, arcs)
    if not kept.any():
        return LadderProgress(ladder, roadmap_of_nodes(checker, robot.home[None], seed), np.zeros(1))
    arcs, rows = arcs[kept], rows[kept]
    used = np.unique(arcs)
    places = along[used]
    first, last = places <= 1e-9, places >= places.max() - 1e-9
    order = np.concatenate([np.flatnonzero(first), np.flatnonzero(last), np.flatnonzero(~first & ~last)])
    number = np.full(len(along), -1)
    number[used[order]] = np.arange(len(order))
    edges = np.sort(number[arcs], axis=1)
    by_ends = np.lexsort((edges[:, 1], edges[:, 0]))
    ends, rows = (np.arange(first.sum()), first.sum() + np.arange(last.sum())), rows[by_ends]
    free = np.maximum(proofs.clearance[rows], 0.0), proofs.samples[rows]
    made = _roadmap(checker, seed, ladder.q[used[order]], ends, edges[by_ends], *free)
    return LadderProgress(ladder, made, places[order])


def _on_the_way(along: Floats, arcs: Ints) -> Bools:
    """(m,) the arcs that lie on a way from the path's beginning to what is farthest along it of all that is reached.

    Rungs are sorted along the path.
    """
    if not len(arcs):
        return np.zeros(0, dtype=bool)
    ahead = reachable(along <= 1e-9, arcs)
    if not ahead[arcs[:, 0]].any():
        return np.zeros(len(arcs), dtype=bool)
    farthest = along[arcs[ahead[arcs[:, 0]], 1]].max()
    back = reachable(ahead & (along >= farthest - 1e-9), arcs[:, ::-1])
    return ahead[arcs[:, 0]] & back[arcs[:, 1]]


def roadmap_of_nodes(checker: CollisionChecker, nodes: Floats, seed: int) -> Roadmap:
    """A roadmap of ``nodes`` (n, dof) alone, the first of them its start, for what is followed nowhere."""
    none = np.zeros(0, dtype=np.int64)
    return _roadmap(checker, seed, nodes, (np.zeros(1, np.int64), none), np.zeros((0, 2), np.int64), np.zeros(0), none)


def _roadmap(
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
        checked_by=unchecked(len(nodes)), scale=scale, origin=record_origin(checker, seed),
    )  # fmt: skip


def attach_ladder(robot: Robot, roadmap: Roadmap, ladder: Roadmap, number: Ints) -> tuple[Roadmap, Ints]:
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


def explain_stop(
    checker: CollisionChecker, ladder: Ladder, share: float, ends: Floats, floor: float | None = None
) -> CannotFollow:
    """The reason why a path is not followed beyond a ``share`` of it, by the next station of its ladder.

    ``ends`` (k, dof) is where it ends; ``floor`` is one that lets it go on, where the one asked for is all that is in
    the way.
    """
    robot, path, stations = ladder.robot, ladder.tube.path, ladder.stations
    beyond = stations[stations > share * stations[-1] + 1e-9] if len(ends) else stations[:1]
    there = float(beyond[0]) if len(beyond) else float(stations[-1])
    line = min(int(np.searchsorted(path.along, there - 1e-9)), len(path.along) - 1)
    begun: dict[str, Any] = {"point": int(path.given[line]), "followed": share}
    if floor is not None:
        return CannotFollow(cause="below_floor", reachable=floor, **begun)
    q, miss = _solutions(robot, ladder.tube, there)
    if not len(q):
        begun |= {"cone": _cone(robot, ladder.tube, there)}
        return _no_solution(robot, ladder.tube, there, miss, begun)
    constraints = checker.world.constraints
    kept = constraints.holds(q)
    if not kept.any():
        spare = max(constraints.spare(q), key=np.min)
        return CannotFollow(
            cause="strays", between=(constraints.texts[spare.argmin()],), distance=float(-spare.min()), **begun
        )
    q = q[kept]
    contacts = [contact_at(checker, one) for one in q[:_LOOKED_AT]]
    if all(contacts):
        named = Counter((found.first, found.second) for found in contacts if found)
        return CannotFollow(cause="touching", between=named.most_common(1)[0][0], **begun)
    free = q[[k for k, found in enumerate(contacts) if found is None]]
    away = 0.0
    if len(ends):
        away = float(np.abs(robot.difference(ends[:, None], free[None])).max(axis=2).min())
    return CannotFollow(cause="jump", distance=away, **begun)


def _solutions(robot: Robot, tube: Tube, along: float) -> tuple[Floats, Floats]:
    """Solutions (k, dof) at a place of the path, and by how much (m, rad) the nearest try misses it."""
    q, off = solutions_at(robot, tube, along, _STARTS, np.random.default_rng(0))
    return q[np.isfinite(q[:, 0])], off[(off[:, 0] + 0.1 * off[:, 1]).argmin()]


def _no_solution(robot: Robot, tube: Tube, there: float, miss: Floats, begun: dict[str, Any]) -> CannotFollow:
    """By how much it is out of reach, or which limits keep the arm from it."""
    wide = np.where(robot.prismatic, 10.0, 4.0 * np.pi)
    unlimited = replace(robot, lower=frozen(robot.lower - wide), upper=frozen(robot.upper + wide))
    q, _ = _solutions(unlimited, tube, there)
    if len(q):
        turned = np.where(robot.prismatic, q, np.mod(q - robot.lower, 2 * np.pi) + robot.lower)
        over = np.where(robot.continuous, 0.0, np.maximum(robot.lower - turned, turned - robot.upper))
        least = over[np.maximum(over, 0.0).sum(axis=1).argmin()]
        joints = tuple(name for name, more in zip(robot.joints, least, strict=True) if more > 0)
        return CannotFollow(cause="beyond_limit", between=joints or robot.joints, **begun)
    if miss[0] > POSITION_TOLERANCE:
        return CannotFollow(cause="out_of_reach", distance=float(miss[0]), **begun)
    return CannotFollow(cause="turned", distance=float(miss[1]), **begun)


def _cone(robot: Robot, tube: Tube, there: float) -> float | None:
    """The narrowest cone (rad) with which solutions are found at a place; 0 where a free turn will do."""
    path = tube.path
    n = len(path.positions)
    for cone in _CONES:
        if (cone > path.cones.max()) if cone else not path.free.any():
            wider = replace(path, free=np.ones(n, bool), cones=np.full(n, cone))
            if len(_solutions(robot, replace(tube, path=wider), there)[0]):
                return cone
    return None
