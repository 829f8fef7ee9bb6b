"""One network over all modes: the roadmap once for each mode, joined where a grasp or a placement is the same in two.

The layers share nodes, edges and costs; what differs is what has to be proven of an edge. All arcs are there from the
beginning, proven or not, so every path over free arcs is a path of this network.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.kinematics.forward import tool_path_lengths
from planner.objective.integral import costs_along
from planner.objective.scale import cost_number, length_cost
from planner.problem.objective import Objective
from planner.roadmap.roadmap import Roadmap
from planner.tasks.file import TaskError
from planner.tasks.modes import Mode, Motions
from planner.tasks.options import NOTHING, Option, Options

NEIGHBOURS = 10  # nodes of the roadmap that each end of a line is joined to
MOST_NODES = 3_000_000  # of the network
TRANSIT, APPROACH, RETREAT = 0, 1, 2
_CHUNK = 256  # ends whose neighbours are looked for at once

Crossing = tuple[int, int, Option, int | None]  # a layer, a step, its option, layer after


@dataclass(frozen=True, eq=False)
class Way:
    """A mode left and another entered by one option of a step, or a goal reached; ``first`` is its first node."""

    step: int
    option: Option
    first: int

    @property
    def last(self) -> int:
        """Its last node."""
        return self.first + len(self.option.motions)


@dataclass(frozen=True, eq=False)
class TaskNetwork:
    """``tails``, ``heads``, ``motion``, ``mode`` and ``leg`` (arcs,) in the order of the network's arcs.

    Nodes are those of the roadmap in layer after layer, ``layered`` of them, then the corners of every way, then the
    ``start``. ``leg`` is 3 step + TRANSIT, APPROACH or RETREAT. ``costs`` (arcs, 2) are what an arc adds to Omega and D
    of eq. (finew). ``reaches`` (nodes,) is the step that a node is on its way to.
    """

    nodes: int
    start: int
    goals: Ints
    tails: Ints
    heads: Ints
    motion: Ints
    mode: Ints
    leg: Ints
    costs: Floats
    modes: tuple[Mode, ...]
    layered: int
    ways: tuple[Way, ...]
    reaches: Ints

    def at(self, beta: float) -> gabf.Network:
        """The network of eq. (finew) at ``beta``, the manipulability cost charged along edges."""
        return gabf.Network.from_arcs(
            self.tails,
            self.heads,
            self.costs[:, 1],
            sources=self.goals,
            n_nodes=self.nodes,
            arc_cost=self.costs[:, 0],
            kernel=gabf.EdgeIntegral(beta=beta),
        )

    @cached_property
    def of_mode(self) -> list[Ints]:
        """The arcs of each mode."""
        order = np.argsort(self.mode, kind="stable")
        return np.split(order, np.searchsorted(self.mode[order], np.arange(1, len(self.modes))))

    def corners(self, motions: Motions, arc: int) -> Floats:
        """The corners (k, dof) of an arc's motion from its tail to its head; edges have one motion for both ways."""
        found = motions.corners(int(self.motion[arc]))
        return found[::-1] if self.layered > self.tails[arc] > self.heads[arc] else found

    def arc(self, tail: int, head: int) -> int:
        """The arc from one node to another."""
        first, last = np.searchsorted(self.tails, [tail, tail + 1])
        return int(first + np.flatnonzero(self.heads[first:last] == head)[0])

    def started(self, options: Options, roadmap: Roadmap, q: Floats, objective: Objective) -> TaskNetwork:
        """The same from another start ``q`` (dof,), joined to its neighbours in the first layer."""
        near = np.sort(_nearest(roadmap, options.modes.robot, q[None])[0])  # arcs in the order of the network
        motion = options.modes.motions.straight(np.repeat(q[None], len(near), axis=0), roadmap.nodes[near])
        start, many = self.nodes, len(near)
        arcs = {
            "tails": np.full(many, start),
            "heads": near,
            "motion": motion,
            "mode": np.zeros(many, dtype=np.int64),
            "leg": np.full(many, TRANSIT),
        }
        more = {name: np.concatenate([getattr(self, name), rows]) for name, rows in arcs.items()}
        costs = np.vstack([self.costs, motion_costs(options, roadmap, objective, motion)])
        reaches = np.append(self.reaches, 0)
        return replace(self, nodes=self.nodes + 1, start=start, costs=costs, reaches=reaches, **more)


def task_network(options: Options, roadmap: Roadmap, objective: Objective) -> TaskNetwork:
    """The network of a task's options over the nodes and edges of ``roadmap``, whose first start is the task's."""
    return _Builder(options, roadmap).network(objective)


class _Builder:
    """Layer after layer: each is a mode before a step."""

    def __init__(self, options: Options, roadmap: Roadmap) -> None:
        self.options, self.roadmap, self.n = options, roadmap, len(roadmap.nodes)
        motions, nodes, edges = options.modes.motions, roadmap.nodes, roadmap.edges
        self.edge_motions = motions.straight(nodes[edges[:, 0]], nodes[edges[:, 1]])
        options.modes.known(("arm",))[self.edge_motions[roadmap.proven]] = 1
        self.modes: dict[Mode, int] = {}
        self.layers: list[tuple[int, Mode]] = []
        self.links = self._links()

    def _links(self) -> dict[int, tuple[tuple[Ints, Ints], tuple[Ints, Ints]]]:
        """Neighbours of both ends of every option, and the straight motions there and off; by the option's id."""
        listed = [o for step in self.options.steps for options in step.values() for o in options]
        flat, robot, motions = (
            np.concatenate([o.ends for o in listed]),
            self.options.modes.robot,
            self.options.modes.motions,
        )
        near = _nearest(self.roadmap, robot, flat)
        many = near.shape[1]
        theirs, mine = self.roadmap.nodes[near].reshape(-1, robot.dof), np.repeat(flat, many, axis=0)
        there, off = (motions.straight(*pair).reshape(-1, many) for pair in ((theirs, mine), (mine, theirs)))
        return {id(o): ((near[2 * k], there[2 * k]), (near[2 * k + 1], off[2 * k + 1])) for k, o in enumerate(listed)}

    def network(self, objective: Objective) -> TaskNetwork:
        """All layers that the steps lead to from the first, and the crossings between them."""
        self.layer_of: dict[tuple[int, Mode], int] = {}
        self._layer(0, self.options.first)
        crossings: list[Crossing] = []
        for layer, (stage, mode) in enumerate(self.layers):  # to which the ways add
            crossings += [(layer, *way) for way in self._ways(stage, mode)]
        return self._assembled(crossings, objective)

    def _layer(self, stage: int, mode: Mode) -> int | None:
        """The number of a layer, None behind the last step."""
        if stage == len(self.options.task.steps):
            return None
        if (stage, mode) not in self.layer_of:
            self.layer_of[stage, mode] = len(self.layers)
            self.layers.append((stage, mode))
            self._number(mode)
            if len(self.layers) * self.n > MOST_NODES:
                raise TaskError(
                    f"the task has more than {len(self.layers) - 1} modes of {self.n} nodes: give fewer grasps, fewer "
                    "placements or fewer --nodes."
                )
        return self.layer_of[stage, mode]

    def _number(self, mode: Mode) -> int:
        return self.modes.setdefault(mode, len(self.modes))

    def _ways(self, stage: int, mode: Mode) -> Iterator[tuple[int, Option, int | None]]:
        """What leads out of a layer: step, option, layer after."""
        found = self.options.steps[stage]
        for key in (NOTHING, *(mode.standing if mode.held is None else (mode.held,))):
            for option in found.get(key, ()):
                yield stage, option, self._layer(stage + 1, _after(mode, option))

    def _assembled(self, crossings: list[Crossing], objective: Objective) -> TaskNetwork:
        columns: list[tuple[Ints, Ints, Ints, Ints, Ints]] = []

        def arcs(tails, heads, motion, mode: Mode, leg: int) -> None:
            tails, heads, motion = np.atleast_1d(tails), np.atleast_1d(heads), np.atleast_1d(motion)
            many = max(len(tails), len(heads))
            same = np.full(many, self._number(mode)), np.full(many, leg)
            columns.append((np.broadcast_to(tails, many), np.broadcast_to(heads, many), motion, *same))

        edges, n = self.roadmap.edges, self.n
        for layer, (stage, mode) in enumerate(self.layers):
            arcs(layer * n + edges[:, 0], layer * n + edges[:, 1], self.edge_motions, mode, 3 * stage)
            arcs(layer * n + edges[:, 1], layer * n + edges[:, 0], self.edge_motions, mode, 3 * stage)
        node, ways, goals = len(self.layers) * n, [], []
        reaches = [np.repeat([stage for stage, _ in self.layers], n)]
        for layer, stage, option, after in crossings:
            (near_in, there), (near_out, off) = self.links[id(option)]
            mode, way = self.layers[layer][1], Way(stage, option, node)
            arcs(layer * n + near_in, node, there, mode, 3 * stage)
            for k, (one, leg) in enumerate(self._lines(mode, option)):
                arcs(node + k, node + k + 1, option.motions[k], one, 3 * stage + leg)
            if after is None:
                goals.append(way.last)
            else:
                arcs(way.last, after * n + near_out, off, self.layers[after][1], 3 * stage + 3)
            ways.append(way)
            reaches.append(np.full(way.last + 1 - node, stage))
            reaches[-1][-1] += 1  # its last corner is behind the step
            node = way.last + 1
        tails, heads, motion, mode, leg = (np.concatenate(column) for column in zip(*columns, strict=True))
        order = np.argsort(tails * node + heads, kind="stable")  # as the network has them
        costs = motion_costs(self.options, self.roadmap, objective, np.arange(self.options.modes.motions.count))
        return TaskNetwork(
            node,
            int(self.roadmap.starts[0]),
            np.array(goals, dtype=np.int64),
            tails[order],
            heads[order],
            motion[order],
            mode[order],
            leg[order],
            costs[motion[order]],
            tuple(self.modes),
            len(self.layers) * n,
            tuple(ways),
            np.concatenate(reaches),
        )

    def _lines(self, mode: Mode, option: Option) -> list[tuple[Mode, int]]:
        """The mode and the leg of each of the motions between an option's corners."""
        if option.place == NOTHING:
            return []
        after, options = _after(mode, option), self.options
        hand, rest = options.at_hand(option.place), options.at_rest(option.place)
        if mode.held is None:
            return [(mode.allowing(*hand), APPROACH), (after.allowing(*rest), RETREAT), (after, RETREAT)]
        return [(mode, APPROACH), (mode.allowing(*rest), APPROACH), (after.allowing(*hand), RETREAT)]


def _after(mode: Mode, option: Option) -> Mode:
    """The mode behind an option: what stood is held, what was held stands, or as it was."""
    if option.place == NOTHING:
        return mode
    if mode.held is None:
        return Mode(tuple(p for p in mode.standing if p != option.place), option.grasp)
    return Mode(tuple(sorted((*mode.standing, option.place))))


def _nearest(roadmap: Roadmap, robot, ends: Floats) -> Ints:
    """The nodes (k, ``NEIGHBOURS``) of the roadmap nearest to ``ends`` (k, dof)."""
    many, rows = min(NEIGHBOURS, len(roadmap.nodes)), []
    for first in range(0, len(ends), _CHUNK):
        away = np.linalg.norm(robot.difference(ends[first : first + _CHUNK, None], roadmap.nodes[None]), axis=2)
        rows.append(np.argsort(away, axis=1, kind="stable")[:, :many])
    return np.concatenate(rows)


def motion_costs(options: Options, roadmap: Roadmap, objective: Objective, motions: Ints) -> Floats:
    """(k, 2) Omega and D of motions as :func:`planner.planning.network.build_network` charges edges, piece by piece."""
    start, delta, owner = options.modes.motions.of(motions)
    robot, length = options.modes.robot, np.linalg.norm(delta, axis=1)
    tool = tool_path_lengths(robot, start, delta) if objective.metric == "workspace" else length
    distance = length_cost(roadmap.scale, objective.metric, length, tool)
    _, means = costs_along(robot, start, delta, roadmap.scale)
    omega = means[:, cost_number(objective.manipulability_cost)] * distance
    row = np.searchsorted(motions, owner)
    summed = (np.bincount(row, values, minlength=len(motions)) for values in (omega, distance))
    return np.column_stack([np.asarray(column, dtype=float) for column in summed])
