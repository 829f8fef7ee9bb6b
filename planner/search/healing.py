"""Second checks of paths, and healing: what fails is removed from the network, and the field finds another path."""

from __future__ import annotations

import itertools

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.collision.looks import straight
from planner.collision.second_look import second_look
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.search.manipulability_floor import first_violation, layered_network


class HealingNetwork:
    """A roadmap and its network, from which whatever fails a second check is removed.

        healing = HealingNetwork(checker, roadmap, network, floor)
        while not healing.accepts(path := ...a node path on healing.layered...):
            ...                                            # solve again: what failed is gone

    An edge fails on which :func:`second_look` sees a contact; an arc fails that falls below the manipulability
    ``floor``, see :func:`first_violation`. ``seen``: what passed in the same world before, to which is added what
    passes now.
    """

    def __init__(
        self,
        checker: CollisionChecker,
        roadmap: Roadmap,
        network: gabf.Network,
        floor: float = 0.0,
        seen: set[bytes] | None = None,
    ) -> None:
        self.roadmap, self.layered, self.floor = roadmap, layered_network(roadmap, network, floor), floor
        self.edges_removed = 0
        self.robot, self._checker = checker.robot, checker
        self._seen = set() if seen is None else seen  # edges that passed: a sweep meets them many times

    def accepts(self, steps: Ints) -> bool:
        """Whether the path over nodes ``steps`` (k,) of the layered network holds; if not, what failed is removed."""
        nodes = self.layered.roadmap_node[steps].tolist()
        new = [edge for edge in itertools.pairwise(nodes) if self._name(edge) not in self._seen]
        failed = self._first_contact(new)
        self._seen |= {self._name(edge) for edge in new[:failed]}
        if failed < len(new):
            i, j = new[failed]
            self.roadmap = self.roadmap.without_edge(self.roadmap.edge_index(i, j))
            self.layered = self.layered.without_edge(i, j)
            self.edges_removed += 1
            return False
        low = first_violation(self.robot, self.waypoints(steps), self.floor)
        if low is None:
            return True
        arc = int(steps[low]), int(steps[low + 1])
        self.layered = self.layered.without_arcs_between(*arc)
        return False

    def waypoints(self, steps: Ints) -> Floats:
        """The configurations (k, dof) of a path over nodes of the layered network."""
        return path_waypoints(self.roadmap, self.robot, self.layered.roadmap_node[steps])

    def _name(self, edge: tuple[int, int]) -> bytes:
        """The edge by what its ends are, in either direction and in any roadmap."""
        return b"".join(sorted(self.roadmap.nodes[node].tobytes() for node in edge))

    def _first_contact(self, edges: list[tuple[int, int]]) -> int:
        """The number of the first of ``edges`` on which a second look sees a contact; how many there are for none."""
        if not edges:
            return 0
        start, end = (self.roadmap.nodes[list(nodes)] for nodes in zip(*edges, strict=True))
        found = second_look(self._checker, straight(start, self.robot.difference(start, end)))
        return len(edges) if found is None else found.piece


def warm_start(network: gabf.Network, cost_to_go: gabf.CostToGo | None, law: gabf.Law) -> Floats | None:
    """The current x as initial states for ``network``, raised where it relied on what was removed.

    None, for the law's own, if there is no x or the law needs an overestimate.
    """
    if cost_to_go is None or law.needs_overestimate:
        return None
    return gabf.raised_start(network, cost_to_go.x)
