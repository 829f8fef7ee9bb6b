"""One network over all modes, and the cheapest proven way through it.

The roadmap stands in it once for each mode, joined where a grasp or a placement is the same in two. The layers share
nodes, edges and costs; what differs is what has to be proven of an edge. An arc is proven in its mode once the field's
path uses it. No arc but a refused one ever goes, so the path costs exactly what the cheapest of all combinations of
grasp, configuration, path and placement costs, planned one by one on the same roadmaps; see
:mod:`planner.search.search`.
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
from planner.search.search import Found, search
from planner.tasks.candidates import NO_OBJECT, Candidate, Candidates
from planner.tasks.modes import ARM, BLOCKED, FREE, OPEN, Mode, Modes, Motions
from planner.tasks.task import TaskError
from planner.tradeoff.envelope import EnvelopeSearch, SupportInterval, support_intervals

NEIGHBOURS = 10  # nodes of the roadmap that each end of a line is joined to
MOST_NODES = 3_000_000  # of the network
TRANSIT, APPROACH, RETREAT = 0, 1, 2
_AT_ONCE = 2000  # open motions of a clause that are proven once one of them is refused
_COLUMNS = ("tails", "heads", "motion", "mode", "leg")  # of arcs


@dataclass(frozen=True, eq=False)
class Transition:
    """A mode left and another entered by a candidate of a step, or a goal reached; its nodes are first to last."""

    step: int
    candidate: Candidate
    first: int
    last: int


@dataclass(frozen=True, eq=False)
class TaskNetwork:
    """``tails``, ``heads``, ``motion``, ``mode`` and ``leg`` (arcs,) in the order of the network's arcs.

    Nodes are those of the roadmap in layer after layer, ``layered`` of them, then the corners of every transition, and
    perhaps another start. ``leg`` is 3 step + TRANSIT, APPROACH or RETREAT. ``costs`` (arcs, 2) are what an arc adds to
    Omega and D of eq. (finew). ``reaches`` (nodes,) is the step that a node is on its way to.
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
        """The network of eq. (finew) at ``beta``, the manipulability cost charged along edges; its arcs are these."""
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

    def with_start(self, modes: Modes, roadmap: Roadmap, q: Floats, objective: Objective) -> TaskNetwork:
        """The same from another start ``q`` (dof,), joined to its neighbours in the first layer."""
        near = np.sort(_find_nearest(roadmap, modes.robot, q[None])[0])  # arcs in the order of the network
        motion = modes.motions.add_edges(np.repeat(q[None], len(near), axis=0), roadmap.nodes[near])
        arcs = dict(zip(_COLUMNS, _arcs(self.nodes, near, motion, 0, TRANSIT), strict=True))
        more = {name: np.append(getattr(self, name), rows) for name, rows in arcs.items()}
        costs = np.vstack([self.costs, _compute_costs(modes, roadmap, objective, motion)])
        reaches = np.append(self.reaches, 0)
        return replace(self, nodes=self.nodes + 1, start=self.nodes, costs=costs, reaches=reaches, **more)


def _arcs(*columns: Ints | int) -> Ints:
    """The five columns (5, k) of some arcs, of which one may be the same in all."""
    return np.stack(np.broadcast_arrays(*columns)).reshape(len(_COLUMNS), -1)


def build_task_network(candidates: Candidates, roadmap: Roadmap, objective: Objective) -> TaskNetwork:
    """The network of a task's candidates over the nodes and edges of ``roadmap``, whose first start is the task's."""
    modes, (first, second), n = candidates.modes, roadmap.edges.T, len(roadmap.nodes)
    along = modes.motions.add_edges(roadmap.nodes[first], roadmap.nodes[second])
    modes.known(ARM)[along[roadmap.proven]] = FREE
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
        for k, (part, leg) in enumerate(_lines(candidates, mode, candidate)):
            part_number = number.setdefault(part, len(number))
            arcs.append(_arcs(node + k, node + k + 1, candidate.motions[k], part_number, 3 * stage + leg))
        if after is None:
            goals.append(last)
        else:
            arcs.append(_arcs(last, after * n + near_out, off, number[layers[after][1]], 3 * stage + 3))
        transitions.append(Transition(stage, candidate, node, last))
        node = last + 1
        reaches.append(np.append(np.full(len(candidate.motions), stage), stage + 1))  # its last is behind the step
    columns = np.concatenate(arcs, axis=1)
    columns = columns[:, np.argsort(columns[0] * node + columns[1], kind="stable")]  # as the network has them
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
    """By the id of a candidate: neighbours of its begin and motions from there, of its end and motions to there."""
    listed = [o for step in candidates.steps for found in step.values() for o in found]
    flat, robot, motions = np.concatenate([o.ends for o in listed]), candidates.modes.robot, candidates.modes.motions
    near = _find_nearest(roadmap, robot, flat)
    theirs, mine = roadmap.nodes[near].reshape(-1, robot.dof), np.repeat(flat, near.shape[1], axis=0)
    there, off = (motions.add_edges(*pair).reshape(near.shape) for pair in ((theirs, mine), (mine, theirs)))
    ends = zip(near[::2], there[::2], near[1::2], off[1::2], strict=True)
    return {id(candidate): found for candidate, found in zip(listed, ends, strict=True)}


def _layers(candidates: Candidates, n: int) -> tuple[list[tuple[int, Mode]], list[tuple[int, Candidate, int | None]]]:
    """All modes before a step (from 0), and the transitions: a layer, a candidate, the layer after."""
    layers, crossings = {(0, candidates.first): 0}, []
    queue = list(layers)
    for stage, mode in queue:  # to which the transitions add
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
    """The mode and the leg of each of the motions between a candidate's corners."""
    if candidate.place == NO_OBJECT:
        return []
    after, place = _after(mode, candidate), candidate.place
    hand, rest = candidates.at_hand(place), candidates.at_rest(place)
    if mode.held is None:
        return [(mode.allow(*hand), APPROACH), (after.allow(*rest), RETREAT), (after, RETREAT)]
    return [(mode, APPROACH), (mode.allow(*rest), APPROACH), (after.allow(*hand), RETREAT)]


def _after(mode: Mode, candidate: Candidate) -> Mode:
    """The mode behind a candidate: what stood is held, what was held stands, or as it was."""
    if candidate.place == NO_OBJECT:
        return mode
    if mode.held is None:
        return Mode(tuple(p for p in mode.standing if p != candidate.place), candidate.grasp)
    return Mode(tuple(sorted((*mode.standing, candidate.place))))


def _find_nearest(roadmap: Roadmap, robot: Robot, ends: Floats) -> Ints:
    """The nodes (k, ``NEIGHBOURS``) of the roadmap nearest to ``ends`` (k, dof)."""
    return find_nearest(robot, roadmap.nodes, ends, min(NEIGHBOURS, len(roadmap.nodes)))[1]


def _compute_costs(modes: Modes, roadmap: Roadmap, objective: Objective, motions: Ints) -> Floats:
    """(k, 2) Omega and D of motions as :func:`planner.search.network.build_network` charges edges, piece by piece."""
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
    """The search of a network of modes at one beta after another; ``refused`` (arcs,) are its arcs without a proof.

    It is a :class:`planner.search.search.LazyNetwork` of the network ``whole`` at the beta asked last. ``fields`` are
    what earlier searches at each beta have found, of the nodes that all networks of a task have.
    """

    whole: gabf.Network

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
        """The arcs that are not refused."""
        return self.whole.without_arcs(np.flatnonzero(self.refused))

    @property
    def starts(self) -> Ints:
        """The one start."""
        return np.array([self.tasks.start])

    def path(self, beta: float, progress: Progress = QUIET) -> tuple[Found, Ints]:
        """The cheapest proven path from the start at ``beta`` and its arcs (k,), none where there is no path."""
        self.whole = self.tasks.at_beta(beta)
        near = min(self.fields, key=lambda known: abs(known - beta), default=None)
        report = progress.with_report(lambda _, done, total: progress("modes", done, total))
        found = search(self, self.law, None if near is None else self.fields[near], progress=report)
        if len(found.steps):
            self.fields[beta] = found.field.x[: self.tasks.transitions[-1].last + 1]
        return found, self.whole.arcs_along(found.steps)

    def pieces(self) -> list[SupportInterval]:
        """Every path that some beta makes the cheapest proven one, with its interval of beta; none for no path."""
        self.whole = self.tasks.at_beta(0.5)
        envelope = EnvelopeSearch(self, self.law)
        while not envelope.is_done:
            envelope.step()
        return support_intervals(envelope.supports)

    def holds(self, steps: Ints) -> bool:
        """Whether a path is proven and holds a second look; if not, what is refused of it, and more, is gone."""
        arcs = self.whole.arcs_along(steps)
        for mode in np.unique(self.tasks.mode[arcs]).tolist():
            mine = arcs[self.tasks.mode[arcs] == mode]
            for clause in self.modes.clauses(self.tasks.modes[mode]):
                self.modes.prove(clause, self.tasks.motion[mine])
                if (self.modes.known(clause)[self.tasks.motion[mine]] == BLOCKED).any():
                    self._prove_more(clause, mode, mine)
                    self._refuse(clause)
        return not self.refused[arcs].any() and self._looks_free(arcs)

    def _prove_more(self, clause: Mode, mode: int, arcs: Ints) -> None:
        """Prove more of a mode's motions in a clause that has refused some ``arcs``: all, or those at their nodes."""
        net, mine = self.tasks, self.tasks.of_mode[mode]
        mine = mine[(self.modes.known(clause)[net.motion[mine]] == OPEN) & ~self.refused[mine]]
        if len(mine) > _AT_ONCE:
            nodes = np.concatenate([net.tails[arcs], net.heads[arcs]])
            mine = mine[np.isin(net.tails[mine], nodes) | np.isin(net.heads[mine], nodes)]
        self.modes.prove(clause, net.motion[mine])

    def _refuse(self, clause: Mode) -> None:
        """The arcs that a clause blocks are refused in all modes that have it."""
        blocked = self.modes.known(clause) == BLOCKED
        for mode in self._users.get(clause, ()):
            mine = self.tasks.of_mode[mode]
            self.refused[mine[blocked[self.tasks.motion[mine]]]] = True

    def _looks_free(self, arcs: Ints) -> bool:
        """A second look at proven arcs: those on which it sees a contact are refused."""
        for number in np.unique(self.tasks.mode[arcs]).tolist():
            mine = arcs[self.tasks.mode[arcs] == number]
            start, delta, owner = self.modes.motions.select(self.tasks.motion[mine])
            seen = recheck_pieces(self.modes.checker_of(self.tasks.modes[number]), straight(start, delta))
            if seen is not None:
                self.refused[mine] |= self.tasks.motion[mine] == owner[seen.piece]
                return False
        return True

    def reached(self) -> int:
        """The step that no path over what is not refused gets beyond."""
        net, begin = self.tasks, np.zeros(self.tasks.nodes, dtype=bool)
        begin[net.start] = True
        arcs = np.stack([net.tails, net.heads], axis=1)[~self.refused]
        return int(net.reaches[reachable(begin, arcs)].max())
