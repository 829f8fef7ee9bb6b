"""The search for a path that is proven now: lazily, along the routes that the field prefers.

Edges that a change has opened count as free until the field's path uses them. Then they are proven, and with the first
that fails those around the path too; the field heals, and its path is another. (Lazy PRM, Bohlin and Kavraki 2000, with
a field in the place of a search.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import PlannerError
from planner.base.progress import QUIET, Progress
from planner.collision import coal_checker, second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.looks import straight
from planner.collision.second_look import second_look
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.search.manipulability_floor import LayeredNetwork, first_violation, layered_network
from planner.session.edge_proofs import clauses_of
from planner.session.live_roadmap import LiveRoadmap

_MANY = 0.5  # share of the clauses beyond which a checker of them alone gains nothing


@dataclass(frozen=True, eq=False)
class Found:
    """Where a search ended: the world with what was proven on the way, the field, and the path.

    ``steps`` (k,) are nodes of the network that is ``layered`` by the floor; none where no edges above it, open ones
    included, join a start and a goal.
    """

    live: LiveRoadmap
    layered: LayeredNetwork
    field: gabf.CostToGo
    steps: Ints
    rounds: int
    raised: int
    updates: int

    @property
    def nodes(self) -> Ints:
        """The path's nodes (k,) in the roadmap."""
        return self.layered.roadmap_node[self.steps]

    @property
    def x(self) -> Floats:
        """The field (n,) over the roadmap's nodes, for the next search to go on from."""
        return self.field.x[: len(self.live.roadmap.nodes)]


class RoadmapNetwork:
    """The network of a roadmap whose edges come and go; costs stay, so it is built once."""

    def __init__(self, roadmap: Roadmap, build: Callable[[Roadmap], gabf.Network]) -> None:
        self.roadmap, self.whole = roadmap, build(roadmap)
        n = len(roadmap.nodes)
        low, high = (choose(self.whole.tails, self.whole.indices) for choose in (np.minimum, np.maximum))
        self._edge = np.searchsorted(roadmap.edges[:, 0] * n + roadmap.edges[:, 1], low * n + high)

    def without(self, edges: Bools) -> gabf.Network:
        """The network that lacks some ``edges`` (m,) of the roadmap."""
        return self.whole.without_arcs(np.flatnonzero(edges[self._edge]))


def edges_of(roadmap: Roadmap, steps: Ints) -> Ints:
    """The edges (k - 1,) between consecutive nodes ``steps`` (k,)."""
    n, edges = len(roadmap.nodes), roadmap.edges
    low, high = np.minimum(steps[:-1], steps[1:]), np.maximum(steps[:-1], steps[1:])
    return np.searchsorted(edges[:, 0] * n + edges[:, 1], low * n + high)


def go_on(progress: Progress) -> None:
    """Raise :class:`PlannerError` where somebody has closed the session meanwhile, or cancelled what it does."""
    if progress.stopped:
        raise PlannerError("it was cancelled, or the session is closed: ask again, or make a new one.")


def search(
    live: LiveRoadmap,
    network: RoadmapNetwork,
    x: Floats,
    law: gabf.Law,
    floor: float = 0.0,
    progress: Progress = QUIET,
) -> Found:
    """The cheapest path over edges that are proven now and hold a second check, from the field ``x`` (n,) on.

    It keeps to the manipulability ``floor``: an arc that is seen to break it is left out from then on. Raises
    :class:`PlannerError` once ``progress`` is asked to stop.
    """
    rounds = raised = updates = 0
    barred: list[tuple[int, int]] = []
    while True:
        go_on(progress)
        layered = layered_network(live.roadmap, network.without(live.proofs.blocked), floor)
        for arc in barred:
            layered = layered.without_arcs_between(*arc)
        x = np.concatenate([x, np.full(layered.network.n_nodes - len(x), np.inf)])  # a floor's copies begin anew
        healing = gabf.heal(layered.network, x, law)
        field, x = healing.cost_to_go, healing.cost_to_go.x
        rounds, raised, updates = rounds + 1, raised + len(healing.raised), updates + healing.updates
        steps = gabf.cheapest_path(field, layered.starts)
        nodes = layered.roadmap_node[steps]
        live, holds = prove_path(live, nodes)
        if not holds:
            continue
        path = path_waypoints(live.roadmap, live.checker.robot, nodes)
        low = first_violation(live.checker.robot, path, floor) if len(path) else None
        if low is None:
            return Found(live, layered, field, steps, rounds, raised, updates)
        barred.append((int(steps[low]), int(steps[low + 1])))


def prove_path(live: LiveRoadmap, steps: Ints, around_too: bool = True) -> tuple[LiveRoadmap, bool]:
    """The world after what was open of a path over nodes ``steps`` (k,) was proven, and whether all of it holds.

    Where it does not the edges around it are proven, too, unless nothing is to be found in its place.
    """
    rows = edges_of(live.roadmap, steps)
    live = live.proven(rows[live.proofs.open[rows]])
    if live.proofs.blocked[rows].any():
        if not around_too:
            return live, False
        around = np.isin(live.roadmap.edges, steps).any(axis=1)
        return live.proven(np.flatnonzero(around & live.proofs.open)), False
    unseen = ~live.proofs.seen[rows]
    if not unseen.any():
        return live, True
    path = path_waypoints(live.roadmap, live.checker.robot, steps)
    new = np.flatnonzero(unseen.any(axis=1))
    second = _judge(live, np.asarray(unseen.any(axis=0)))
    contact = second_look(live.checker, straight(path[new], path[new + 1] - path[new]), second=second)
    if contact is not None:
        return replace(live, proofs=live.proofs.refused(int(rows[new[contact.piece]]))), False
    return replace(live, proofs=live.proofs.confirmed(rows)), True


def _judge(live: LiveRoadmap, clauses: Bools) -> CollisionChecker:
    """A second checker that knows at least the pairs of some clauses, and is quicker for knowing few."""
    if clauses.mean() > _MANY or not clauses.any():
        return second_checker(live.checker)
    pairs = clauses[clauses_of(live.world)[1]]
    known = live.checker if live.checker.name == "coal" else None
    return coal_checker(live.world.only(pairs), known)
