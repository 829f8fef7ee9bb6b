"""The search for a path that is proven now: edges that a change has opened are proven once the field's path uses them.

With the first edge that fails those around the path are proven too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import PlannerError
from planner.base.progress import QUIET, Progress
from planner.collision import coal_checker, second_checker
from planner.collision.checker import CollisionChecker
from planner.collision.looks import second_look, straight
from planner.roadmap.roadmap import path_waypoints
from planner.search.manipulability_floor import LayeredNetwork
from planner.search.network import edge_rows
from planner.search.search import Found, RoadmapPaths, search
from planner.session.edge_proofs import clauses_of
from planner.session.live_roadmap import LiveRoadmap

_MANY = 0.5  # share of the clauses beyond which a checker of them alone gains nothing


@dataclass(frozen=True, eq=False)
class LiveFound(Found):
    """What a search found, and the world with what was proven on the way; ``layered`` is its network."""

    live: LiveRoadmap
    layered: LayeredNetwork

    @property
    def nodes(self) -> Ints:
        """The path's nodes (k,) in the roadmap."""
        return self.layered.roadmap_node[self.steps]

    @property
    def x(self) -> Floats:
        """The field (n,) over the roadmap's nodes, for the next search to go on from."""
        return self.field.x[: len(self.live.roadmap.nodes)]


def go_on(progress: Progress) -> None:
    """Raise :class:`PlannerError` where the session was closed meanwhile, or its call cancelled."""
    if progress.stopped:
        raise PlannerError("it was cancelled, or the session is closed: ask again, or make a new one.")


def search_live(
    live: LiveRoadmap,
    network: gabf.Network,
    x: Floats,
    law: gabf.Law,
    floor: float = 0.0,
    progress: Progress = QUIET,
) -> LiveFound:
    """The cheapest path over edges that are proven now and hold a second look, from the field ``x`` (n,) on.

    ``network`` is of all the roadmap's edges. Raises :class:`PlannerError` once ``progress`` is asked to stop.
    """
    go_on(progress)

    def prove(nodes: Ints) -> Ints:
        nonlocal live
        before = live.proofs.blocked
        live, _ = prove_path(live, nodes)
        return np.flatnonzero(live.proofs.blocked & ~before)

    paths = RoadmapPaths(live.roadmap, live.checker.robot, network, floor, prove)
    paths.remove(np.flatnonzero(live.proofs.blocked))
    found = search(paths, law, x, progress=progress)
    go_on(progress)
    return LiveFound(**vars(found), live=live, layered=paths.layered)


def prove_path(live: LiveRoadmap, steps: Ints, around_too: bool = True) -> tuple[LiveRoadmap, bool]:
    """The world after what was open of a path over nodes ``steps`` (k,) was proven, and whether all of it holds.

    Where it does not the edges around it are proven, too, unless nothing is to be found in its place.
    """
    rows = edge_rows(live.roadmap, steps[:-1], steps[1:])
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
