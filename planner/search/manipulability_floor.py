"""A floor under manipulability: the network of the paths on a roadmap that stay above it.

The start or the goal may itself lie below the floor. A path then has up to three phases:

1. from the start up to the floor, where w stays at or above the start's own w; 2. above the floor; 3. from the floor
down to the goal, where w stays at or above the goal's own w.

The dynamics cannot know the phase of a node. So the network has layers: one layer has the nodes above the floor, and
each start or goal below the floor adds a layer with its own copies of the nodes below it. Arcs lead from the layers of
starts to the nodes above the floor, and from there to the layers of goals.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, frozen
from planner.base.resolutions import W_AGAINST_FLOOR
from planner.kinematics.manipulability import manipulability
from planner.native.graphs import cheapest_nodes
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.robot.robot import Robot
from planner.search.network import cheapest_steps, edge_rows
from planner.trajectory.measure import dense_path, dense_segments

_ROUNDING = 1e-9  # relative: w of one state computed from two ends of an edge
_LOWER = 0.95  # from one candidate floor to the next
_LEAST = 0.01  # of the first candidate floor: lower ones are ignored
_MOST_PATHS = 100  # whose edges are sampled more finely in search of the highest floor
_FINER, _ZOOMS = 8, 7  # each zoom at a low sample is so many times finer: to 5e-10 rad


@dataclass(frozen=True, eq=False)
class LayeredNetwork:
    """The network of the dynamics, the roadmap node of each of its nodes, and its starts.

    Without a floor it is the roadmap itself. ``roadmap_node`` (k,) begins with the roadmap's nodes in their order.
    """

    network: gabf.Network
    roadmap_node: Ints
    starts: Ints

    def __post_init__(self) -> None:
        for name in ("roadmap_node", "starts"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.int64))

    def on_roadmap(self, x: Floats) -> Floats:
        """Return the cost-to-go (n,) of the roadmap's own nodes: the least over the layers of a node."""
        least = np.full(self.roadmap_node.max() + 1, np.inf)
        np.minimum.at(least, self.roadmap_node, x)
        return least

    def without_edges(self, edges: Ints) -> LayeredNetwork:
        """Return the network without the arcs of the roadmap's ``edges`` (k, 2) in all layers."""
        n = int(self.roadmap_node.max(initial=0)) + 1
        tails, heads = self.roadmap_node[self.network.tails], self.roadmap_node[self.network.indices]
        of_arc = np.minimum(tails, heads) * n + np.maximum(tails, heads)
        gone = np.isin(of_arc, edges.min(axis=1) * n + edges.max(axis=1))
        return replace(self, network=self.network.without_arcs(np.flatnonzero(gone)))

    def without_arcs_between(self, i: int, j: int) -> LayeredNetwork:
        """Return the network without the arcs between two of its own nodes."""
        arcs = np.concatenate([self.network.arcs_between(i, j), self.network.arcs_between(j, i)])
        return replace(self, network=self.network.without_arcs(arcs))


def build_layers(roadmap: Roadmap, network: gabf.Network, floor: float = 0.0) -> LayeredNetwork:
    """Return the network of all paths on ``roadmap`` above ``floor`` (w), with the costs of ``network``.

    Along an edge w is known only at the states saved with the roadmap: check the path with :func:`find_violation`.
    """
    if floor <= 0:
        return LayeredNetwork(network, np.arange(network.n_nodes), roadmap.starts)
    n, w = len(roadmap.nodes), roadmap.manipulability
    nodes, below, arcs = np.arange(n), np.flatnonzero(w < floor), _ArcsAtFloor(roadmap, network, floor)
    groups, layers = [(arcs.above, nodes, nodes)], []  # arcs, and the number of each roadmap node at tails and heads
    for ends, up in ((roadmap.starts, True), (roadmap.goals, False)):
        for least in np.unique(w[ends][w[ends] < floor]).tolist():
            copy = np.full(n, -1, dtype=np.int64)
            copy[below] = n + len(layers) * len(below) + np.arange(len(below))
            layers.append(_Layer(least, up, copy))
            enough = arcs.least >= (1.0 - _ROUNDING) * least
            groups.append((arcs.below & enough, copy, copy))
            groups.append((arcs.up & enough, copy, nodes) if up else (arcs.down & enough, nodes, copy))
    chosen = np.concatenate([np.flatnonzero(mask) for mask, _, _ in groups])
    roadmap_node = np.concatenate([nodes, np.tile(below, len(layers))])
    graph = gabf.Network.from_arcs(
        np.concatenate([tail[network.tails[mask]] for mask, tail, _ in groups]),
        np.concatenate([head[network.indices[mask]] for mask, _, head in groups]),
        network.weight[chosen],
        sources=_ends(roadmap.goals, w, floor, layers, up=False),
        n_nodes=len(roadmap_node),
        node_cost=None if network.node_cost is None else network.node_cost[roadmap_node],
        arc_cost=None if network.arc_cost is None else network.arc_cost[chosen],
        kernel=network.kernel,
    )
    return LayeredNetwork(graph, roadmap_node, _ends(roadmap.starts, w, floor, layers, up=True))


class _ArcsAtFloor:
    """The least w on each arc, and masks of arcs above the floor, below it, crossing it up or down."""

    def __init__(self, roadmap: Roadmap, network: gabf.Network, floor: float) -> None:
        w = roadmap.edge_manipulability[edge_rows(roadmap, network.tails, network.indices)]
        above = np.where((network.tails > network.indices)[:, None], w[:, ::-1], w) >= floor
        steps, first, last = np.diff(above.astype(np.int8), axis=1), above[:, 0], above[:, -1]
        self.least = w.min(axis=1)
        self.above, self.below = above.all(axis=1), ~above.any(axis=1)
        self.up = (steps >= 0).all(axis=1) & ~first & last
        self.down = (steps <= 0).all(axis=1) & first & ~last


@dataclass(frozen=True, eq=False)
class _Layer:
    """A copy of the nodes below the floor, for paths up from a start or down to a goal of w ``least``."""

    least: float
    up: bool
    copy: Ints  # (n,) the number of each roadmap node's copy, -1 above the floor


def _ends(ends: Ints, w: Floats, floor: float, layers: list[_Layer], up: bool) -> Ints:
    """Return the nodes of the layered network at which paths may start (``up``) or end.

    An end above the floor is its own node. An end below it is its copy in its own layer, and also its copies in the
    layers of the other direction, for paths that never reach the floor: such a path stays in one layer, that of its
    start or that of its goal.
    """
    numbers = [[node] for node in ends[w[ends] >= floor]]
    for node in ends[w[ends] < floor]:
        numbers.append([layer.copy[node] for layer in layers if layer.up != up or layer.least == w[node]])
    return np.array(list(itertools.chain(*numbers)), dtype=np.int64)


def find_violation(robot: Robot, path: Floats, floor: float) -> int | None:
    """Return the first segment on which a joint path (k, dof) breaks the floor; None if none does.

    Sampled every 0.001 rad, and ever finer around the lowest samples: w = 0 may lie between two that are above. A path
    respects the floor if w is nowhere below the smallest of the floor, w at the start and w at the goal, and stays
    above the floor between the first and the last state that reach it.
    """
    if floor <= 0:
        return None
    q, segment = dense_segments(path, W_AGAINST_FLOOR)
    w = manipulability(robot, q)
    dips = _dips(robot, q, w)
    bad = dips < (1.0 - _ROUNDING) * min(floor, w[0], w[-1])
    above = np.flatnonzero(w >= floor)
    if len(above):
        between = slice(above[0] + 1, above[-1] + 1)
        bad[between] |= dips[between] < floor
    return int(segment[np.argmax(bad)]) if bad.any() else None


def highest_floor(robot: Robot, roadmap: Roadmap, network: gabf.Network, requested: float | None = None) -> float:
    """Return the highest floor that a path of ``network`` is known to respect, at two digits; 0 for none.

    That is the highest w above which all of a path lies, rounded down. If the ``requested`` floor is too high, lower
    floors are candidates too, from above, as paths to them may begin and end lower: a lower floor may forbid a path
    that a higher one allows. Floors above all w on the roadmap allow the same paths: the highest w is the first
    candidate.
    """
    all_above = round_down(_highest_bottleneck(robot, roadmap, network))
    if requested is None:
        return all_above
    floor = top = round_down(_LOWER * min(requested, roadmap.edge_manipulability.max(initial=0.0)))
    while floor > max(all_above, _LEAST * top):
        layered = build_layers(roadmap, network, floor)
        path = path_waypoints(roadmap, robot, layered.roadmap_node[cheapest_steps(layered.network, layered.starts)])
        if len(path) and find_violation(robot, path, floor) is None:
            return floor
        floor = round_down(_LOWER * floor)
    return min(all_above, top) if all_above > _LEAST * top else 0.0


def _highest_bottleneck(robot: Robot, roadmap: Roadmap, network: gabf.Network) -> float:
    """Return the largest w below which some path never falls; 0 without a path.

    Edges count first with their saved states; those on a best path are sampled more finely, as w may dip between
    states, until all edges of a best path are.
    """
    rows, arcs = edge_rows(roadmap, network.tails, network.indices), np.stack([network.tails, network.indices], axis=1)
    least, sampled = roadmap.edge_manipulability.min(axis=1, initial=np.inf), np.zeros(len(roadmap.edges), dtype=bool)

    def path(bar: float) -> Ints:
        allowed = arcs[least[rows] >= bar]
        return cheapest_nodes(len(roadmap.nodes), allowed, np.ones(len(allowed)), roadmap.starts, network.sources)

    highest = 0.0
    for _ in range(_MOST_PATHS):
        bars = np.unique(np.append(least, 0.0))
        low, high = 0, len(bars)  # paths lead over arcs from bars[low] up, none over those from bars[high] up
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if len(path(bars[middle])) else (low, middle)
        nodes = path(bars[low])
        if len(nodes) < 2:  # no path, or a start that is a goal
            return float(roadmap.manipulability[nodes].min(initial=np.inf)) if len(nodes) else 0.0
        passed = edge_rows(roadmap, nodes[:-1], nodes[1:])
        for row in passed[~sampled[passed]]:
            q = dense_path(path_waypoints(roadmap, robot, roadmap.edges[row]), W_AGAINST_FLOOR)
            least[row] = _dips(robot, q, manipulability(robot, q)).min()
        sampled[passed] = True
        highest = max(highest, float(least[passed].min()))
        if highest >= bars[low]:
            break
    return highest


def _dips(robot: Robot, q: Floats, w: Floats) -> Floats:
    """Return ``w`` (n,) of samples ``q`` (n, dof), lowered to the least w near each low sample.

    A dip after a sample counts for the next one, as that may be on another segment.
    """
    padded = np.concatenate([[np.inf], w, [np.inf]])
    low = np.flatnonzero((w <= padded[:-2]) & (w <= padded[2:]))
    at, dips, rows = q[low], w.copy(), np.arange(len(low))
    before, after = q[np.maximum(low - 1, 0)] - at, q[np.minimum(low + 1, len(q) - 1)] - at
    shares = np.arange(1, _FINER + 1)[:, None, None] / _FINER
    moved, later = np.zeros((2, len(low)), dtype=bool)  # whether the least is off the sample, and whether after it
    for _ in range(_ZOOMS):
        states = at + np.concatenate([np.zeros_like(at)[None], shares * before, shares * after])
        values = manipulability(robot, states.reshape(-1, q.shape[1])).reshape(len(states), -1)
        best = values.argmin(axis=0)
        moved, later = moved | (best > 0), np.where(moved, later, best > _FINER)
        np.minimum.at(dips, low + later, values[best, rows])
        side, inside = np.where((best > _FINER)[:, None], after, before) / _FINER, (best > 0)[:, None]
        before, after = np.where(inside, -side, before / _FINER), np.where(inside, side, after / _FINER)
        at = states[best, rows]
    return dips


def round_down(w: float) -> float:
    """Return ``w`` >= 0 with two significant digits, never above it."""
    if w <= 0.0:
        return 0.0
    unit = math.floor(math.log10(w)) - 1
    return float(f"{math.floor(w / 10.0**unit)}e{unit}")
