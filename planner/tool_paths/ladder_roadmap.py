"""The ladder of a tool path as a roadmap, alone or attached to a free one, and reasons for its end."""

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
from planner.roadmap.measure import measure_edges
from planner.roadmap.roadmap import EDGE_ARRAYS, NODE_ARRAYS, Roadmap, record_origin
from planner.robot.robot import Robot
from planner.tool_paths.ladder import Ladder, solutions_at
from planner.tool_paths.tube import Tube

NEW, LEFT_OUT = -1, -2  # marks of a ladder's nodes for attach_ladder
_STARTS = 300  # descents to explain a stop
_CONES = (0.0, 0.05, 0.1, 0.2, 0.4, 0.8)  # rad
_MOST_CONTACTS = 40  # solutions that are checked for contacts


@dataclass(frozen=True, eq=False)
class LadderProgress:
    """The part of a ``ladder`` that free motions above a floor connect to its first rungs.

    These rungs are the starts of ``roadmap``, its goals are the rungs farthest along the path. Without any such motion
    it holds the robot's home alone, and has no goal. ``along`` (n,) m: the nodes' positions on the path.
    """

    ladder: Ladder
    roadmap: Roadmap
    along: Floats

    @property
    def share(self) -> float:
        """The reached share of the path's length."""
        return float(self.along.max() / self.ladder.stations[-1])

    @property
    def whole(self) -> bool:
        """Whether the end is reached."""
        return self.share >= 1.0 - 1e-9

    @property
    def ends(self) -> Floats:
        """(k, dof) the farthest rungs; none if the path cannot start."""
        return self.roadmap.nodes[self.roadmap.goals]


def follow_ladder(
    ladder: Ladder, checker: CollisionChecker, floor: float, seed: int, progress: Progress = QUIET
) -> LadderProgress:
    """Return the ladder's motions that are free and above ``floor``, as far as they lead from its start."""
    robot, along, arcs = ladder.robot, ladder.along, ladder.arcs
    arcs = arcs[_find_useful_arcs(along, arcs)]
    start = ladder.q[arcs[:, 0]]
    delta = robot.difference(start, ladder.q[arcs[:, 1]])
    proofs = EdgeProver(checker, progress, "proofs").prove(start, delta, contacts=False)
    good = proofs.free
    if floor > 0:
        rows = np.flatnonzero(good)
        good[rows] = prove_floor(robot, np.stack([start, delta], axis=1)[rows], floor).holds
    arcs, rows = arcs[good], np.flatnonzero(good)
    useful = _find_useful_arcs(along, arcs)
    if not useful.any():
        return LadderProgress(ladder, roadmap_of_nodes(checker, robot.home[None], seed), np.zeros(1))
    arcs, rows = arcs[useful], rows[useful]
    used = np.unique(arcs)
    stations = along[used]
    first, last = stations <= 1e-9, stations >= stations.max() - 1e-9
    order = np.concatenate([np.flatnonzero(first), np.flatnonzero(last), np.flatnonzero(~first & ~last)])
    number = np.full(len(along), -1)
    number[used[order]] = np.arange(len(order))
    edges = np.sort(number[arcs], axis=1)
    by_ends = np.lexsort((edges[:, 1], edges[:, 0]))
    ends, rows = (np.arange(first.sum()), first.sum() + np.arange(last.sum())), rows[by_ends]
    free = np.maximum(proofs.clearance[rows], 0.0), proofs.samples[rows]
    roadmap = _roadmap(checker, seed, ladder.q[used[order]], ends, edges[by_ends], *free)
    return LadderProgress(ladder, roadmap, stations[order])


def _find_useful_arcs(along: Floats, arcs: Ints) -> Bools:
    """Return which arcs (m,) lie on a way from the path's start to the farthest rung that is reached.

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
    """Return a roadmap of ``nodes`` (n, dof) without edges; the first is its start."""
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
    """Return the roadmap of proven edges, on a scale of its own."""
    robot, w = checker.robot, node_manipulability(checker.robot, nodes)
    measured = measure_edges(robot, nodes, edges, CostScale(1.0, 2.0, 1.0, 1.0, 0.01))
    scale = measure_scale(w, measured["joint_length"], measured["tool_length"])
    return Roadmap(
        nodes=nodes, edges=edges, proven=np.ones(len(edges), dtype=bool), starts=ends[0], goals=ends[1],
        manipulability=w, **measure_edges(robot, nodes, edges, scale), clearance=clearance, samples=samples,
        checked_by=np.zeros(len(nodes), dtype=np.int8), scale=scale, origin=record_origin(checker, seed),
    )  # fmt: skip


def attach_ladder(robot: Robot, roadmap: Roadmap, ladder: Roadmap, number: Ints) -> tuple[Roadmap, Ints]:
    """Return the roadmap with the nodes of a ladder after its own, and their numbers (n,) there.

    ``number`` (n,) holds the roadmap's numbers of nodes that it already has, NEW for others, and LEFT_OUT for those to
    omit. The cost scale is the roadmap's.
    """
    n, new = len(roadmap.nodes), number == NEW
    number = np.where(new, n + np.cumsum(new) - 1, number)
    chosen = (number >= 0)[ladder.edges].all(axis=1)
    edges = np.sort(number[ladder.edges[chosen]], axis=1)
    nodes = {name: np.concatenate([getattr(roadmap, name), getattr(ladder, name)[new]]) for name in NODE_ARRAYS}
    arcs: dict[str, Any] = {name: getattr(ladder, name)[chosen] for name in EDGE_ARRAYS} | {"edges": edges}
    arcs |= measure_edges(robot, nodes["nodes"], edges, roadmap.scale)
    joined = {name: np.concatenate([getattr(roadmap, name), arcs[name]]) for name in EDGE_ARRAYS}
    order = np.lexsort((joined["edges"][:, 1], joined["edges"][:, 0]))
    return replace(roadmap, **nodes, **{name: array[order] for name, array in joined.items()}), number


def explain_stop(
    checker: CollisionChecker, ladder: Ladder, share: float, ends: Floats, floor: float | None = None
) -> CannotFollow:
    """Return the reason why a path is not followed beyond a ``share`` of it, at the ladder's next station.

    The motion ends at ``ends`` (k, dof). ``floor`` is a lower one that allows the motion, if the requested floor is the
    only obstacle.
    """
    robot, path, stations = ladder.robot, ladder.tube.path, ladder.stations
    beyond = stations[stations > share * stations[-1] + 1e-9] if len(ends) else stations[:1]
    along = float(beyond[0]) if len(beyond) else float(stations[-1])
    line = min(int(np.searchsorted(path.along, along - 1e-9)), len(path.along) - 1)
    fields: dict[str, Any] = {"point": int(path.given[line]), "followed": share}
    if floor is not None:
        return CannotFollow(cause="below_floor", reachable=floor, **fields)
    q, miss = _solutions(robot, ladder.tube, along)
    if not len(q):
        fields |= {"cone": _find_cone(robot, ladder.tube, along)}
        return _explain_no_solution(robot, ladder.tube, along, miss, fields)
    constraints = checker.world.constraints
    holds = constraints.holds(q)
    if not holds.any():
        spare = max(constraints.slacks(q), key=np.min)
        return CannotFollow(
            cause="strays", between=(constraints.texts[spare.argmin()],), distance=float(-spare.min()), **fields
        )
    q = q[holds]
    contacts = [contact_at(checker, one) for one in q[:_MOST_CONTACTS]]
    if all(contacts):
        pairs = Counter((contact.first, contact.second) for contact in contacts if contact)
        return CannotFollow(cause="touching", between=pairs.most_common(1)[0][0], **fields)
    free = q[[k for k, contact in enumerate(contacts) if contact is None]]
    away = 0.0
    if len(ends):
        away = float(np.abs(robot.difference(ends[:, None], free[None])).max(axis=2).min())
    return CannotFollow(cause="jump", distance=away, **fields)


def _solutions(robot: Robot, tube: Tube, along: float) -> tuple[Floats, Floats]:
    """Return solutions (k, dof) ``along`` m of the path, and the error (m, rad) of the nearest try."""
    q, off = solutions_at(robot, tube, along, _STARTS, np.random.default_rng(0))
    return q[np.isfinite(q[:, 0])], off[(off[:, 0] + 0.1 * off[:, 1]).argmin()]


def _explain_no_solution(robot: Robot, tube: Tube, along: float, miss: Floats, fields: dict[str, Any]) -> CannotFollow:
    """Return the reason: joint limits, or the distance or angle out of reach."""
    wide = np.where(robot.prismatic, 10.0, 4.0 * np.pi)
    unlimited = replace(robot, lower=frozen(robot.lower - wide), upper=frozen(robot.upper + wide))
    q, _ = _solutions(unlimited, tube, along)
    if len(q):
        turned = np.where(robot.prismatic, q, np.mod(q - robot.lower, 2 * np.pi) + robot.lower)
        over = np.where(robot.continuous, 0.0, np.maximum(robot.lower - turned, turned - robot.upper))
        least = over[np.maximum(over, 0.0).sum(axis=1).argmin()]
        joints = tuple(name for name, more in zip(robot.joints, least, strict=True) if more > 0)
        return CannotFollow(cause="beyond_limit", between=joints or robot.joints, **fields)
    if miss[0] > POSITION_TOLERANCE:
        return CannotFollow(cause="out_of_reach", distance=float(miss[0]), **fields)
    return CannotFollow(cause="turned", distance=float(miss[1]), **fields)


def _find_cone(robot: Robot, tube: Tube, along: float) -> float | None:
    """Return the narrowest cone (rad) that has solutions there, 0 for a free turn; None without one."""
    path = tube.path
    n = len(path.positions)
    for cone in _CONES:
        if (cone > path.cones.max()) if cone else not path.free.any():
            wider = replace(path, free=np.ones(n, bool), cones=np.full(n, cone))
            if len(_solutions(robot, replace(tube, path=wider), along)[0]):
                return cone
    return None
