"""The one search for a proven path: solve the field, prove its path, remove a failed edge, heal.

Plans, sweeps, sessions and tasks share it. They differ in the proof of a path, see :class:`LazyNetwork`. (Lazy PRM,
Bohlin and Kavraki 2000, with a field that heals instead of a search from scratch.)
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.progress import QUIET, Progress, Stopwatch
from planner.collision.checker import CollisionChecker
from planner.collision.recheck import recheck_pieces, straight
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.robot.robot import Robot
from planner.search.manipulability_floor import LayeredNetwork, build_layers, find_violation
from planner.search.network import edge_rows


class LazyNetwork(Protocol):
    """A network whose arcs count as free until a path that uses them has failed."""

    @property
    def network(self) -> gabf.Network:
        """The remaining arcs, between constant nodes."""
        ...

    @property
    def starts(self) -> Ints:
        """The nodes (s,) at which a path may start."""
        ...

    def prove_path(self, steps: Ints) -> bool:
        """Prove the path over nodes ``steps`` (k,); on failure, remove at least one of its arcs.

        Returns whether the path is proven.
        """
        ...


@dataclass(frozen=True, eq=False)
class ProvenNetwork:
    """A lazy network whose arcs are all proven."""

    network: gabf.Network
    starts: Ints

    def prove_path(self, steps: Ints) -> bool:
        return True


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The settled field and the proven path over nodes ``steps`` (k,); (0,) without a path or on a stop.

    ``rounds`` counts the solved fields.
    """

    field: gabf.CostToGo
    steps: Ints
    rounds: int


def search(
    lazy: LazyNetwork,
    law: gabf.Law,
    x: Floats | None = None,
    clock: Stopwatch | None = None,
    progress: Progress = QUIET,
) -> SearchResult:
    """Return the cheapest path of a lazy network that is proven, and its field.

    The search removes failed arcs only. So every network on the way contains all proven paths, its cheapest path costs
    no more than the cheapest of these, and the first path that is proven is the cheapest. The dynamics starts from the
    states ``x`` (n,) of the first n nodes, then from each earlier field, raised where it relied on a removed arc; a law
    that needs an overestimate starts from one each time.
    """
    clock, rounds = clock or Stopwatch(), 0
    while True:
        progress("path", rounds, 0)
        with clock("gabf"):
            network = lazy.network
            if x is None or law.needs_overestimate:
                field = gabf.solve(network, law=law)
            else:
                new = np.full(network.n_nodes - len(x), np.inf)
                field = gabf.heal(network, np.append(x, new), law).cost_to_go
            x, rounds = field.x, rounds + 1
        with clock("path"):
            steps = gabf.cheapest_path(field, lazy.starts)
            stopped = progress.stopped
            if stopped or not len(steps) or lazy.prove_path(steps):
                progress("path", rounds, 0)
                return SearchResult(field, steps[:0] if stopped else steps, rounds)


class RoadmapPaths:
    """The paths of a roadmap that stay above a manipulability ``floor``, as a :class:`LazyNetwork`.

    ``prove(nodes)`` proves the edges between consecutive roadmap nodes (k,). It returns the rows of the edges to
    remove, none where all of the path's are proven. An arc on which the path falls below the floor is removed too.
    ``kept`` (m,) marks the edges that have not failed.
    """

    def __init__(
        self,
        roadmap: Roadmap,
        robot: Robot,
        network: gabf.Network | LayeredNetwork,
        floor: float,
        prove: Callable[[Ints], Ints],
    ) -> None:
        self._roadmap, self._robot, self._floor, self._prove = roadmap, robot, floor, prove
        self.layered = network if isinstance(network, LayeredNetwork) else build_layers(roadmap, network, floor)
        self.kept = np.ones(len(roadmap.edges), dtype=bool)

    @property
    def network(self) -> gabf.Network:
        return self.layered.network

    @property
    def starts(self) -> Ints:
        return self.layered.starts

    @property
    def roadmap(self) -> Roadmap:
        """The roadmap without the edges that failed."""
        if self.kept.all():
            return self._roadmap
        return self._roadmap.part(np.ones(len(self._roadmap.nodes), dtype=bool), self.kept)

    def prove_path(self, steps: Ints) -> bool:
        failed = self._prove(self.layered.roadmap_node[steps])
        if len(failed):
            self.remove(failed)
            return False
        low = find_violation(self._robot, self.waypoints(steps), self._floor)
        if low is not None:
            self.layered = self.layered.without_arcs_between(int(steps[low]), int(steps[low + 1]))
        return low is None

    def remove(self, rows: Ints) -> None:
        """Remove the edges ``rows`` (k,) in every layer."""
        self.kept[rows] = False
        self.layered = self.layered.without_edges(self._roadmap.edges[rows])

    def waypoints(self, steps: Ints) -> Floats:
        """Return the configurations (k, dof) of a path over nodes of the layered network."""
        return path_waypoints(self._roadmap, self._robot, self.layered.roadmap_node[steps])


def make_recheck(
    checker: CollisionChecker, roadmap: Roadmap, seen: set[bytes] | None = None, progress: Progress = QUIET
) -> Callable[[Ints], Ints]:
    """Return the proof of a path of proven edges: a second check of them, see :func:`second_look`.

    The first edge with a contact fails. ``seen`` contains the edges that passed in the same world, on any roadmap,
    which are not checked again; edges that pass are added.
    """
    passed, robot = set() if seen is None else seen, checker.robot

    def look(nodes: Ints) -> Ints:
        rows = edge_rows(roadmap, nodes[:-1], nodes[1:])
        names = [b"".join(sorted(q.tobytes() for q in roadmap.nodes[roadmap.edges[row]])) for row in rows]
        new = np.array([k for k, name in enumerate(names) if name not in passed], dtype=np.int64)
        if not len(new):
            return new
        start, end = roadmap.nodes[nodes[new]], roadmap.nodes[nodes[new + 1]]
        report = partial(progress, "second look")
        contact = recheck_pieces(checker, straight(start, robot.difference(start, end)), progress=report)
        first = len(new) if contact is None else contact.piece
        passed.update(names[k] for k in new[:first])
        return rows[new[first : first + 1]]

    return look
