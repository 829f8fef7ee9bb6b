"""One network over all modes, and its cheapest proven path.

The network has one layer of the roadmap per mode; grasps and placements connect the layers. Layers share nodes, edges
and costs; only the proofs of an edge differ. An arc is proven in its mode when the field's path uses it. Only refused
arcs are removed, so the path is optimal over all combinations of grasp, configuration, path and placement on these
roadmaps; see :mod:`planner.search.search`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.recheck import recheck_pieces, straight
from planner.cost.scale import cost_number, costs_along, length_cost
from planner.kinematics.forward import tool_path_lengths
from planner.native.graphs import reachable
from planner.problem.request import Objective
from planner.roadmap.connections import find_nearest
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot
from planner.search.search import SearchResult, search
from planner.tasks.candidates import NO_OBJECT, Candidate, Candidates
from planner.tasks.modes import ARM, BLOCKED, FREE, OPEN, Mode, Modes, Motions
from planner.tasks.task import TaskError
from planner.tradeoff.envelope import EnvelopeSearch, SupportInterval, support_intervals

NEIGHBOURS = 10  # nodes of the roadmap connected to each end of a line
MOST_NODES = 3_000_000  # of the network
TRANSIT, APPROACH, RETREAT = 0, 1, 2
_AT_ONCE = 2000  # open motions of a clause that one refusal proves at most
_COLUMNS = ("tails", "heads", "motion", "mode", "leg")  # of arcs


@dataclass(frozen=True, eq=False)
class Transition:
    """A change of mode by a candidate of a step, or a reached goal; its nodes are ``first`` to ``last``."""

    step: int
    candidate: Candidate
    first: int
    last: int


@dataclass(frozen=True, eq=False)
class TaskNetwork:
    """``tails``, ``heads``, ``motion``, ``mode`` and ``leg`` (arcs,) in the order of the network's arcs.

    Nodes are ``layered`` nodes of the roadmap, layer by layer, then the corners of all transitions, and optionally
    another start. ``leg`` is 3 step + TRANSIT, APPROACH or RETREAT. ``costs`` (arcs, 2) are the terms Omega and D of
    eq. (finew). ``reaches`` (nodes,) is the next step of each node.
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
    transitions: tuple[Transition, ...]
    reaches: Ints

    def at_beta(self, beta: float) -> gabf.Network:
        """Return the network of eq. (finew) at ``beta``, with these arcs and costs integrated over edges."""
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
        """Arcs of each mode."""
        order = np.argsort(self.mode, kind="stable")
        return np.split(order, np.searchsorted(self.mode[order], np.arange(1, len(self.modes))))

    def corners(self, motions: Motions, arc: int) -> Floats:
        """Return the corners (k, dof) of an arc's motion from tail to head."""
        corners = motions.corners(int(self.motion[arc]))
        return corners[::-1] if self.layered > self.tails[arc] > self.heads[arc] else corners

    def with_start(self, modes: Modes, roadmap: Roadmap, q: Floats, objective: Objective) -> TaskNetwork:
        """Return the network with another start ``q`` (dof,), connected to neighbours in the first layer."""
        near = np.sort(_find_nearest(roadmap, modes.robot, q[None])[0])  # in the network's order of arcs
        motion = modes.motions.add_edges(np.repeat(q[None], len(near), axis=0), roadmap.nodes[near])
        arcs = dict(zip(_COLUMNS, _arcs(self.nodes, near, motion, 0, TRANSIT), strict=True))
        more = {name: np.append(getattr(self, name), rows) for name, rows in arcs.items()}
        costs = np.vstack([self.costs, _compute_costs(modes, roadmap, objective, motion)])
        reaches = np.append(self.reaches, 0)
        return replace(self, nodes=self.nodes + 1, start=self.nodes, costs=costs, reaches=reaches, **more)


def _arcs(*columns: Ints | int) -> Ints:
    """Return the five columns (5, k) of arcs; scalars are repeated."""
    return np.stack(np.broadcast_arrays(*columns)).reshape(len(_COLUMNS), -1)


def build_task_network(candidates: Candidates, roadmap: Roadmap, objective: Objective) -> TaskNetwork:
    """Build the network of a task's candidates over ``roadmap``, whose first start is that of the task."""
    modes, (first, second), n = candidates.modes, roadmap.edges.T, len(roadmap.nodes)
    along = modes.motions.add_edges(roadmap.nodes[first], roadmap.nodes[second])
    modes.verdicts_of(ARM)[along[roadmap.proven]] = FREE
    joints = _connect_ends(candidates, roadmap)
    layers, crossings = _layers(candidates, n)
    number = {mode: k for k, mode in enumerate(dict.fromkeys(mode for _, mode in layers))}
    arcs = []
    for layer, (stage, mode) in enumerate(layers):
        for tails, heads in ((first, second), (second, first)):
            arcs.append(_arcs(layer * n + tails, layer * n + heads, along, number[mode], 3 * stage))
    node, transitions, goals, reaches = len(layers) * n, [], [], [np.repeat([stage for stage, _ in layers], n)]
    for layer, candidate, after in crossings:
        (stage, mode), (near_in, there, near_out, off) = layers[layer], joints[id(candidate)]
        last = node + len(candidate.motions)
        arcs.append(_arcs(layer * n + near_in, node, there, number[mode], 3 * stage))
        for k, (line_mode, leg) in enumerate(_lines(candidates, mode, candidate)):
            mode_number = number.setdefault(line_mode, len(number))
            arcs.append(_arcs(node + k, node + k + 1, candidate.motions[k], mode_number, 3 * stage + leg))
        if after is None:
            goals.append(last)
        else:
            arcs.append(_arcs(last, after * n + near_out, off, number[layers[after][1]], 3 * stage + 3))
        transitions.append(Transition(stage, candidate, node, last))
        node = last + 1
        reaches.append(np.append(np.full(len(candidate.motions), stage), stage + 1))  # the last node is behind the step
    columns = np.concatenate(arcs, axis=1)
    columns = columns[:, np.argsort(columns[0] * node + columns[1], kind="stable")]  # the network's order of arcs
    costs = _compute_costs(modes, roadmap, objective, np.arange(modes.motions.count))
    return TaskNetwork(
        nodes=node,
        start=int(roadmap.starts[0]),
        goals=np.array(goals, dtype=np.int64),
        **dict(zip(_COLUMNS, columns, strict=True)),
        costs=costs[columns[2]],
        modes=tuple(number),
        layered=len(layers) * n,
        transitions=tuple(transitions),
        reaches=np.concatenate(reaches),
    )


def _connect_ends(candidates: Candidates, roadmap: Roadmap) -> dict[int, tuple[Ints, Ints, Ints, Ints]]:
    """Return by id of a candidate: neighbours of its first and last corner, and the motions between."""
    listed = [one for step in candidates.steps for ones in step.values() for one in ones]
    flat, robot, motions = (
        np.concatenate([one.ends for one in listed]),
        candidates.modes.robot,
        candidates.modes.motions,
    )
    near = _find_nearest(roadmap, robot, flat)
    theirs, mine = roadmap.nodes[near].reshape(-1, robot.dof), np.repeat(flat, near.shape[1], axis=0)
    there, off = (motions.add_edges(*pair).reshape(near.shape) for pair in ((theirs, mine), (mine, theirs)))
    ends = zip(near[::2], there[::2], near[1::2], off[1::2], strict=True)
    return {id(candidate): joints for candidate, joints in zip(listed, ends, strict=True)}


def _layers(candidates: Candidates, n: int) -> tuple[list[tuple[int, Mode]], list[tuple[int, Candidate, int | None]]]:
    """Return all pairs of step (from 0) and mode, and transitions as layer, candidate, next layer."""
    layers, crossings = {(0, candidates.first): 0}, []
    queue = list(layers)
    for stage, mode in queue:  # transitions append to it
        for key in (NO_OBJECT, *(mode.standing if mode.held is None else (mode.held,))):
            for candidate in candidates.steps[stage].get(key, ()):
                after = stage + 1, _after(mode, candidate)
                if after not in layers and stage + 1 < len(candidates.steps):
                    layers[after] = len(layers)
                    queue.append(after)
                crossings.append((layers[stage, mode], candidate, layers.get(after)))
        if len(layers) * n > MOST_NODES:
            have = f"the task must have at most {MOST_NODES} nodes in all modes, got {len(layers) * n}"
            raise TaskError(f"{have}: give fewer grasps, fewer placements or fewer --nodes.")
    return queue, crossings


def _lines(candidates: Candidates, mode: Mode, candidate: Candidate) -> list[tuple[Mode, int]]:
    """Return mode and leg of each motion between a candidate's corners."""
    if candidate.place == NO_OBJECT:
        return []
    after, place = _after(mode, candidate), candidate.place
    hand, rest = candidates.at_hand(place), candidates.at_rest(place)
    if mode.held is None:
        return [(mode.allow(*hand), APPROACH), (after.allow(*rest), RETREAT), (after, RETREAT)]
    return [(mode, APPROACH), (mode.allow(*rest), APPROACH), (after.allow(*hand), RETREAT)]


def _after(mode: Mode, candidate: Candidate) -> Mode:
    """Return the mode after a candidate: picked, placed, or unchanged."""
    if candidate.place == NO_OBJECT:
        return mode
    if mode.held is None:
        return Mode(tuple(p for p in mode.standing if p != candidate.place), candidate.grasp)
    return Mode(tuple(sorted((*mode.standing, candidate.place))))


def _find_nearest(roadmap: Roadmap, robot: Robot, ends: Floats) -> Ints:
    """Return the nodes (k, ``NEIGHBOURS``) of the roadmap nearest to ``ends`` (k, dof)."""
    return find_nearest(robot, roadmap.nodes, ends, min(NEIGHBOURS, len(roadmap.nodes)))[1]


def _compute_costs(modes: Modes, roadmap: Roadmap, objective: Objective, motions: Ints) -> Floats:
    """Return Omega and D (k, 2) of motions, as :func:`planner.search.network.build_network` for edges."""
    start, delta, owner = modes.motions.select(motions)
    robot, length = modes.robot, np.linalg.norm(delta, axis=1)
    tool = tool_path_lengths(robot, start, delta) if objective.metric == "workspace" else length
    distance = length_cost(roadmap.scale, objective.metric, length, tool)
    _, means = costs_along(robot, start, delta, roadmap.scale)
    omega = means[:, cost_number(objective.manipulability_cost)] * distance
    row = np.searchsorted(motions, owner)
    summed = (np.bincount(row, values, minlength=len(motions)) for values in (omega, distance))
    return np.column_stack([np.asarray(column, dtype=float) for column in summed])


class LazySearch:
    """Search a network over modes at several betas; ``refused`` (arcs,) are arcs whose proof failed.

    A :class:`planner.search.search.LazyNetwork` of the network ``complete`` at the last beta. ``fields`` are the
    fields of earlier searches by beta, over the nodes common to all networks of a task.
    """

    complete: gabf.Network

    def __init__(
        self, modes: Modes, network: TaskNetwork, law: gabf.Law, fields: dict[float, Floats] | None = None
    ) -> None:
        self.modes, self.tasks, self.law = modes, network, law
        self.fields = {} if fields is None else fields
        self.refused = np.zeros(len(network.tails), dtype=bool)
        self._users: dict[Mode, list[int]] = {}
        for number, mode in enumerate(network.modes):
            for clause in modes.clauses(mode):
                self._users.setdefault(clause, []).append(number)
        for clause in list(modes.verdicts):
            self._refuse(clause)

    @property
    def network(self) -> gabf.Network:
        """The network without refused arcs."""
        return self.complete.without_arcs(np.flatnonzero(self.refused))

    @property
    def starts(self) -> Ints:
        """The start, as an array (1,)."""
        return np.array([self.tasks.start])

    def path(self, beta: float, progress: Progress = QUIET) -> tuple[SearchResult, Ints]:
        """Return the cheapest proven path at ``beta`` and its arcs (k,), empty without a path."""
        self.complete = self.tasks.at_beta(beta)
        near = min(self.fields, key=lambda known: abs(known - beta), default=None)
        report = progress.with_report(lambda _, done, total: progress("modes", done, total))
        result = search(self, self.law, None if near is None else self.fields[near], progress=report)
        if len(result.steps):
            self.fields[beta] = result.field.x[: self.tasks.transitions[-1].last + 1]
        return result, self.complete.arcs_along(result.steps)

    def intervals(self) -> list[SupportInterval]:
        """Return all paths that are optimal for some beta, with their intervals of beta; empty without a path."""
        self.complete = self.tasks.at_beta(0.5)
        envelope = EnvelopeSearch(self, self.law)
        while not envelope.is_done:
            envelope.step()
        return support_intervals(envelope.supports)

    def prove_path(self, steps: Ints) -> bool:
        """Prove and recheck a path; return whether it is free, and refuse its blocked arcs and others."""
        arcs = self.complete.arcs_along(steps)
        for mode in np.unique(self.tasks.mode[arcs]).tolist():
            mine = arcs[self.tasks.mode[arcs] == mode]
            for clause in self.modes.clauses(self.tasks.modes[mode]):
                self.modes.prove(clause, self.tasks.motion[mine])
                if (self.modes.verdicts_of(clause)[self.tasks.motion[mine]] == BLOCKED).any():
                    self._prove_more(clause, mode, mine)
                    self._refuse(clause)
        return not self.refused[arcs].any() and self._looks_free(arcs)

    def _prove_more(self, clause: Mode, mode: int, arcs: Ints) -> None:
        """Prove a mode's motions in a clause that refused some ``arcs``, or if many, those at their nodes."""
        net, mine = self.tasks, self.tasks.of_mode[mode]
        mine = mine[(self.modes.verdicts_of(clause)[net.motion[mine]] == OPEN) & ~self.refused[mine]]
        if len(mine) > _AT_ONCE:
            nodes = np.concatenate([net.tails[arcs], net.heads[arcs]])
            mine = mine[np.isin(net.tails[mine], nodes) | np.isin(net.heads[mine], nodes)]
        self.modes.prove(clause, net.motion[mine])

    def _refuse(self, clause: Mode) -> None:
        """Refuse the arcs that a clause blocks, in all modes with this clause."""
        blocked = self.modes.verdicts_of(clause) == BLOCKED
        for mode in self._users.get(clause, ()):
            mine = self.tasks.of_mode[mode]
            self.refused[mine[blocked[self.tasks.motion[mine]]]] = True

    def _looks_free(self, arcs: Ints) -> bool:
        """Recheck proven arcs by sampling; refuse those in contact and return whether there are none."""
        for number in np.unique(self.tasks.mode[arcs]).tolist():
            mine = arcs[self.tasks.mode[arcs] == number]
            start, delta, owner = self.modes.motions.select(self.tasks.motion[mine])
            contact = recheck_pieces(self.modes.checker_of(self.tasks.modes[number]), straight(start, delta))
            if contact is not None:
                self.refused[mine] |= self.tasks.motion[mine] == owner[contact.piece]
                return False
        return True

    def blocking_step(self) -> int:
        """Return the step that no path without refused arcs completes."""
        net, begin = self.tasks, np.zeros(self.tasks.nodes, dtype=bool)
        begin[net.start] = True
        arcs = np.stack([net.tails, net.heads], axis=1)[~self.refused]
        return int(net.reaches[reachable(begin, arcs)].max())
