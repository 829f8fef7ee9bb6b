"""The cheapest way through all modes, proven: an arc is proven in its mode once the field's path uses it.

No arc but a refused one ever goes, so the path costs exactly what the cheapest of all combinations of grasp,
configuration, path and placement costs, planned one by one on the same roadmaps; see :mod:`planner.search.search`.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.collision.checker import CollisionChecker
from planner.collision.looks import second_look, straight
from planner.native.graphs import reached
from planner.search.search import search
from planner.tasks.modes import BLOCKED, NONE, OPEN, Mode, Modes
from planner.tasks.network import TaskNetwork
from planner.tradeoff.envelope import EnvelopeSearch, Piece, pieces

_AT_ONCE = 2000  # open motions of a clause that are proven once one of them is refused


@dataclass(frozen=True, eq=False)
class Found:
    """The field where the search ended, and the ``arcs`` (k,) of its path; none where there is no path."""

    field: gabf.CostToGo
    arcs: Ints
    rounds: int
    refused: int


class LazySearch:
    """A network of modes with what is refused of its arcs (arcs,), for one search after another.

    ``fields`` are what the last search at each beta left behind, (nodes,) but for other starts.
    """

    def __init__(self, modes: Modes, network: TaskNetwork, law: gabf.Law) -> None:
        self.modes, self.network, self.law = modes, network, law
        self.fields: dict[float, Floats] = {}
        self._lasting = network.nodes
        self.refused = np.zeros(len(network.tails), dtype=bool)
        self._seen: set[tuple[int, int]] = set()  # (mode, motion) that a second look found free
        self._users: dict[Mode, list[int]] = {}
        for number, mode in enumerate(network.modes):
            for clause in modes.clauses(mode):
                self._users.setdefault(clause, []).append(number)
        for clause in list(modes.verdicts):
            self._refuse(clause)

    def started(self, network: TaskNetwork) -> LazySearch:
        """The search of a network that has one more start behind its other nodes, with all that is known by now."""
        made = copy(self)
        made.network = network
        made.refused = np.append(self.refused, np.zeros(len(network.tails) - len(self.refused), dtype=bool))
        return made

    def path(self, beta: float, progress: Progress = QUIET) -> Found:
        """The cheapest proven path from the start at ``beta``, from the field at the nearest beta on."""
        nearest = min(self.fields, key=lambda known: abs(known - beta), default=None)
        paths, report = _Paths(self, beta), progress.renamed(lambda _, done, total: progress("modes", done, total))
        found = search(paths, self.law, None if nearest is None else self.fields[nearest], progress=report)
        if len(found.steps):
            self.fields[beta] = found.field.x[: self._lasting]
        refused = len(self.refused) - found.field.network.n_arcs
        return Found(found.field, paths.whole.arcs_along(found.steps), found.rounds, refused)

    def pieces(self) -> list[Piece]:
        """Every path that some beta makes the cheapest proven one, with its interval of beta; none for no path."""
        envelope = EnvelopeSearch(_Paths(self, 0.5), self.law)
        while not envelope.done:
            envelope.step()
        return pieces(envelope.supports)

    def holds(self, arcs: Ints) -> bool:
        """Whether a path is proven and holds a second look; if not, what is refused of it, and more, is gone."""
        for mode in np.unique(self.network.mode[arcs]).tolist():
            mine = arcs[self.network.mode[arcs] == mode]
            for clause in self.modes.clauses(self.network.modes[mode]):
                self.modes.prove(clause, self.network.motion[mine])
                if (self.modes.known(clause)[self.network.motion[mine]] == BLOCKED).any():
                    self._prove_more(clause, mode, mine)
                    self._refuse(clause)
        return not self.refused[arcs].any() and self._looks_free(arcs)

    def _prove_more(self, clause: Mode, mode: int, arcs: Ints) -> None:
        """Prove more of a mode's motions in a clause that has refused some ``arcs``: all, or those at their nodes."""
        mine = self.network.of_mode[mode]
        mine = mine[(self.modes.known(clause)[self.network.motion[mine]] == OPEN) & ~self.refused[mine]]
        nodes = np.concatenate([self.network.tails[arcs], self.network.heads[arcs]])
        touching = np.isin(self.network.tails[mine], nodes) | np.isin(self.network.heads[mine], nodes)
        chosen = mine if len(mine) <= _AT_ONCE else mine[touching]
        self.modes.prove(clause, self.network.motion[chosen])

    def _refuse(self, clause: Mode) -> None:
        """The arcs that a clause blocks are refused in all modes that have it."""
        blocked = self.modes.known(clause) == BLOCKED
        for mode in self._users.get(clause, ()):
            mine = self.network.of_mode[mode]
            self.refused[mine[blocked[self.network.motion[mine]]]] = True

    def _looks_free(self, arcs: Ints) -> bool:
        """A second look at proven arcs: those on which it sees a contact are refused.

        First as if nothing were allowed to touch, in a world that more modes share.
        """
        for number in np.unique(self.network.mode[arcs]).tolist():
            mine = [arc for arc in arcs[self.network.mode[arcs] == number].tolist() if self._key(arc) not in self._seen]
            mode, touching = self.network.modes[number], None
            for world in (replace(mode, allowed=NONE), mode) if mine else ():
                touching = self._touching(self.modes.checker_of(world), self.network.motion[mine])
                if touching is None:
                    break
            if touching is not None:
                self.refused[mine] |= self.network.motion[mine] == touching
                return False
            self._seen.update(map(self._key, mine))
        return True

    def _touching(self, checker: CollisionChecker, motions: Ints) -> int | None:
        """The first of ``motions`` on which a contact is seen."""
        start, delta, owner = self.modes.motions.of(motions)
        seen = second_look(checker, straight(start, delta))
        return None if seen is None else int(owner[seen.piece])

    def _key(self, arc: int) -> tuple[int, int]:
        return int(self.network.mode[arc]), int(self.network.motion[arc])

    def reached(self) -> int:
        """The step that no path over what is not refused gets beyond."""
        net, begin = self.network, np.zeros(self.network.nodes, dtype=bool)
        begin[net.start] = True
        arcs = np.stack([net.tails, net.heads], axis=1)[~self.refused]
        return int(net.reaches[reached(begin, arcs)].max())


class _Paths:
    """The paths of a task's network at a beta, without the arcs that are refused; a lazy network."""

    def __init__(self, search: LazySearch, beta: float) -> None:
        self._search, self.whole = search, search.network.at(beta)
        self.starts = np.array([search.network.start])

    @property
    def network(self) -> gabf.Network:
        return self.whole.without_arcs(np.flatnonzero(self._search.refused))

    def holds(self, steps: Ints) -> bool:
        return self._search.holds(self.whole.arcs_along(steps))
