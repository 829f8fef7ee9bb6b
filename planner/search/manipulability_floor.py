"""A floor under manipulability: the part of a roadmap on which a path keeps above it.

The start or the goal may itself lie below the floor. A path then has up to three parts:

1. from the start up to the floor, where w stays at or above the start's own w;
2. above the floor;
3. from the floor down to the goal, where w stays at or above the goal's own w.

The dynamics cannot tell which part of a path a node belongs to. So the network is built in layers: one layer has the
nodes above the floor, and each start or goal below the floor adds a layer with its own copies of the nodes below it.
Arcs lead from the layers of starts to the nodes above the floor, and from there to the layers of goals.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, as_frozen
from planner.base.resolutions import W_AGAINST_FLOOR
from planner.kinematics.manipulability import manipulability
from planner.native.graphs import cheapest_nodes
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.robot.robot import Robot
from planner.search.network import cheapest_steps, edge_rows
from planner.trajectory.measure import dense_path, dense_segments

_ROUNDING = 1e-9  # relative: w of one state computed from two ends of an edge
_LOWER = 0.95  # from one floor that is tried to the next
_LEAST = 0.01  # of the first floor: lower ones are not tried
_MOST_PATHS = 100  # whose edges are sampled anew in search of the highest floor
_FINER, _ZOOMS = 8, 7  # around a low sample so many times finer, so often: to 5e-10 rad


@dataclass(frozen=True, eq=False)
class LayeredNetwork:
    """What the dynamics runs on: a network, the roadmap node that each of its nodes stands for, and where paths start.

    Without a floor it is the roadmap itself. ``roadmap_node`` (k,) begins with the roadmap's nodes in their order.
    """

    network: gabf.Network
    roadmap_node: Ints
    starts: Ints

    def __post_init__(self) -> None:
        for name in ("roadmap_node", "starts"):
            object.__setattr__(self, name, as_frozen(getattr(self, name), np.int64))

    def on_roadmap(self, x: Floats) -> Floats:
        """The cost-to-go (n,) of the roadmap's own nodes: a node's least, where a floor has several stretches."""
        least = np.full(self.roadmap_node.max() + 1, np.inf)
        np.minimum.at(least, self.roadmap_node, x)
        return least

    def without_edges(self, edges: Ints) -> LayeredNetwork:
        """The layered network without every arc along the roadmap's ``edges`` (k, 2), whichever layer it is in."""
        n = int(self.roadmap_node.max(initial=0)) + 1
        tails, heads = self.roadmap_node[self.network.tails], self.roadmap_node[self.network.indices]
        of_arc = np.minimum(tails, heads) * n + np.maximum(tails, heads)
        gone = np.isin(of_arc, edges.min(axis=1) * n + edges.max(axis=1))
        return replace(self, network=self.network.without_arcs(np.flatnonzero(gone)))

    def without_arcs_between(self, i: int, j: int) -> LayeredNetwork:
        """The layered network without the arcs between two nodes of its own network."""
        arcs = np.concatenate([self.network.arcs_between(i, j), self.network.arcs_between(j, i)])
        return replace(self, network=self.network.without_arcs(arcs))


def layered_network(roadmap: Roadmap, network: gabf.Network, floor: float = 0.0) -> LayeredNetwork:
    """The network of all paths on ``roadmap`` that keep to ``floor`` (w), with the costs of its ``network``.

    Along an edge w is known only at the states kept with the roadmap: check the path with :func:`first_violation`.
    """
    if floor <= 0:
        return LayeredNetwork(network, np.arange(network.n_nodes), roadmap.starts)
    layers, arcs_by_kind = _Layers(roadmap, floor), _Arcs(roadmap, network, floor)
    parts = [(arcs_by_kind.arcs(_Kind.ABOVE, 0.0), layers.roadmap, layers.roadmap)]
    for layer in layers.layers_below:
        parts.append((arcs_by_kind.arcs(_Kind.BELOW, layer.least), layer.copy, layer.copy))
        if layer.up:
            parts.append((arcs_by_kind.arcs(_Kind.UP, layer.least), layer.copy, layers.roadmap))
        else:
            parts.append((arcs_by_kind.arcs(_Kind.DOWN, layer.least), layers.roadmap, layer.copy))
    arcs = np.concatenate([part[0] for part in parts])
    tails = np.concatenate([tail[network.tails[rows]] for rows, tail, _ in parts])
    heads = np.concatenate([head[network.indices[rows]] for rows, _, head in parts])
    graph = gabf.Network.from_arcs(
        tails,
        heads,
        network.weight[arcs],
        sources=layers.ends(roadmap.goals, up=False),
        n_nodes=len(layers.roadmap_node),
        node_cost=None if network.node_cost is None else network.node_cost[layers.roadmap_node],
        arc_cost=None if network.arc_cost is None else network.arc_cost[arcs],
        kernel=network.kernel,
    )
    return LayeredNetwork(graph, layers.roadmap_node, layers.ends(roadmap.starts, up=True))


def first_violation(robot: Robot, path: Floats, floor: float) -> int | None:
    """The first segment on which a joint path (k, dof) breaks the floor; None if none does.

    Sampled every 0.001 rad, and ever finer around the lowest samples: w = 0 may lie between two that are above.
    A path keeps to the floor if w is nowhere below the smallest of the floor, w at the start and w at the goal, and
    stays above the floor between the first and the last state that reach it.
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


def highest_floor(robot: Robot, roadmap: Roadmap, network: gabf.Network, asked: float | None = None) -> float:
    """The highest floor found that a path of ``network`` keeps to, rounded down to two digits; 0 for none.

    That is the highest w above which all of a path lies. Where a floor was ``asked`` for and is too high, floors below
    it are tried too, from above, as paths to them may begin and end lower: a lower floor may forbid a path that a
    higher one allows. Floors above all w on the roadmap allow the same paths: the highest w is tried first.
    """
    all_above = rounded_down(_highest_bottleneck(robot, roadmap, network))
    if asked is None:
        return all_above
    floor = top = rounded_down(_LOWER * min(asked, roadmap.edge_manipulability.max(initial=0.0)))
    while floor > max(all_above, _LEAST * top):
        layered = layered_network(roadmap, network, floor)
        path = path_waypoints(roadmap, robot, layered.roadmap_node[cheapest_steps(layered.network, layered.starts)])
        if len(path) and first_violation(robot, path, floor) is None:
            return floor
        floor = rounded_down(_LOWER * floor)
    return min(all_above, top) if all_above > _LEAST * top else 0.0


def _highest_bottleneck(robot: Robot, roadmap: Roadmap, network: gabf.Network) -> float:
    """The largest w below which some path never falls; 0 where no path is.

    Edges are first taken by the states that are kept of them; those on a best path are sampled anew, as w may dip in
    between, until all edges of a best path have been.
    """
    rows, arcs = edge_rows(roadmap, network.tails, network.indices), np.stack([network.tails, network.indices], axis=1)
    least, sampled = roadmap.edge_manipulability.min(axis=1, initial=np.inf), np.zeros(len(roadmap.edges), dtype=bool)

    def path(bar: float) -> Ints:
        kept = arcs[least[rows] >= bar]
        return cheapest_nodes(len(roadmap.nodes), kept, np.ones(len(kept)), roadmap.starts, network.sources)

    found = 0.0
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
        found = max(found, float(least[passed].min()))
        if found >= bars[low]:
            break
    return found


def _dips(robot: Robot, q: Floats, w: Floats) -> Floats:
    """``w`` (n,) of samples ``q`` (n, dof), lowered to the least found between a sample that is low and its neighbours.

    What lies after such a sample counts for the next one, as that may be on another segment.
    """
    padded = np.concatenate([[np.inf], w, [np.inf]])
    low = np.flatnonzero((w <= padded[:-2]) & (w <= padded[2:]))
    at, dips, rows = q[low], w.copy(), np.arange(len(low))
    before, after = q[np.maximum(low - 1, 0)] - at, q[np.minimum(low + 1, len(q) - 1)] - at
    shares = np.arange(1, _FINER + 1)[:, None, None] / _FINER
    moved, later = np.zeros((2, len(low)), dtype=bool)  # whether the least is beside a sample, and whether after it
    for _ in range(_ZOOMS):
        states = at + np.concatenate([np.zeros_like(at)[None], shares * before, shares * after])
        found = manipulability(robot, states.reshape(-1, q.shape[1])).reshape(len(states), -1)
        best = found.argmin(axis=0)
        moved, later = moved | (best > 0), np.where(moved, later, best > _FINER)
        np.minimum.at(dips, low + later, found[best, rows])
        side, inside = np.where((best > _FINER)[:, None], after, before) / _FINER, (best > 0)[:, None]
        before, after = np.where(inside, -side, before / _FINER), np.where(inside, side, after / _FINER)
        at = states[best, rows]
    return dips


class _Kind(Enum):
    """Where an arc lies relative to the floor."""

    ABOVE = auto()
    BELOW = auto()
    UP = auto()  # crosses it once
    DOWN = auto()


class _Arcs:
    """The arcs of a network by where they lie relative to the floor, with the least w on each."""

    def __init__(self, roadmap: Roadmap, network: gabf.Network, floor: float) -> None:
        tails, heads = network.tails, network.indices
        w = roadmap.edge_manipulability[edge_rows(roadmap, tails, heads)]
        w = np.where((tails > heads)[:, None], w[:, ::-1], w)
        above = w >= floor
        rises = (np.diff(above.astype(np.int8), axis=1) >= 0).all(axis=1)
        falls = (np.diff(above.astype(np.int8), axis=1) <= 0).all(axis=1)
        first, last = above[:, 0], above[:, -1]
        self._least = w.min(axis=1)
        self._of = {
            _Kind.ABOVE: above.all(axis=1),
            _Kind.BELOW: ~above.any(axis=1),
            _Kind.UP: rises & ~first & last,
            _Kind.DOWN: falls & first & ~last,
        }

    def arcs(self, kind: _Kind, least: float) -> Ints:
        """The arcs (k,) of a kind on which w is at least ``least``."""
        return np.flatnonzero(self._of[kind] & (self._least >= (1.0 - _ROUNDING) * least))


@dataclass(frozen=True, eq=False)
class _Layer:
    """A copy of the nodes below the floor for paths up to it, or down from it, whose end has the w ``least``."""

    least: float
    up: bool
    copy: Ints  # (n,) the copy's number of each roadmap node, -1 for those above the floor


class _Layers:
    """The roadmap's nodes, then their copies, layer by layer."""

    def __init__(self, roadmap: Roadmap, floor: float) -> None:
        n, self._w = len(roadmap.nodes), roadmap.manipulability
        self._floor = floor
        self.roadmap = np.arange(n)
        below = np.flatnonzero(self._w < floor)
        bars = [(w, up) for ends, up in ((roadmap.starts, True), (roadmap.goals, False)) for w in self._bars(ends)]
        self.roadmap_node = np.concatenate([self.roadmap, np.tile(below, len(bars))])
        layers_below = []
        for k, (least, up) in enumerate(bars):
            copy = np.full(n, -1, dtype=np.int64)
            copy[below] = n + k * len(below) + np.arange(len(below))
            layers_below.append(_Layer(least, up, copy))
        self.layers_below = tuple(layers_below)

    def _bars(self, ends: Ints) -> list[float]:
        return np.unique(self._w[ends][self._w[ends] < self._floor]).tolist()

    def ends(self, nodes: Ints, up: bool) -> Ints:
        """The nodes of the layered network at which paths may start (``up``) or end.

        An end above the floor is its own node. An end below it is its copy in its own layer, and also its copies in
        the layers of the other direction, for paths that never reach the floor: such a path stays in one layer, that
        of its start or that of its goal.
        """
        numbers = [[node] for node in nodes[self._w[nodes] >= self._floor]]
        for node in nodes[self._w[nodes] < self._floor]:
            numbers.append([t.copy[node] for t in self.layers_below if t.up != up or t.least == self._w[node]])
        return np.array(list(itertools.chain(*numbers)), dtype=np.int64)


def rounded_down(w: float) -> float:
    """``w`` >= 0 with two significant digits, never above it."""
    if w <= 0.0:
        return 0.0
    unit = math.floor(math.log10(w)) - 1
    return float(f"{math.floor(w / 10.0**unit)}e{unit}")
