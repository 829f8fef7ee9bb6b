"""One block: its rows, the states that it received, and the two halves of a step between which it receives others."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.gabf.flows import Flow
from planner.gabf.parents import parents_of
from planner.gabf.problem import Rows, Standing

_NOT_SENT = np.empty(0)


class Block:
    """The states ``y`` of a block's own rows, of those it receives (the next ``halo``), and of sources.

    ``sent``: the own rows that others read. It may live in another process: arrays go in and out, and the order of
    calls is sketch, advance (again from sketch where the step was too long), accept.
    """

    def __init__(self, rows: Rows, y: Floats, sent: Ints, halo: int, flow: Flow) -> None:
        self._flow, self._parents, self._sent, self._n_rows = flow, parents_of(rows), sent, rows.n_rows
        self._halo = slice(rows.n_rows, rows.n_rows + halo)
        self._here, self._mid, self._next = self._parents.standing(y), y, y
        self._kept: dict[int, Floats] = {0: y}
        self._steps = 0

    def report(self) -> Standing:
        """How the block stands, without its arrays: what all blocks together need to know of it."""
        return self._here._replace(y=_NOT_SENT, xhat=_NOT_SENT)

    def retire(self, least: float) -> None:
        """Stop looking at rows that rest for good; ``least`` is the lowest moving state of all blocks."""
        self._parents = self._parents.retire(self._here, least)

    def sketch(self, dtau: float, size: float, forget: bool) -> Floats:
        """The states to send, half a step on; earlier states are given up where ``forget``."""
        if forget:
            self._kept = {self._steps: self._here.y}
        self._mid = self._parents.sketch(self._flow, self._here, dtau, size)
        return self._mid[self._sent]

    def advance(self, dtau: float, size: float, halo: Floats) -> tuple[float, Floats]:
        """How far off the step may be, and the states to send at its end; ``halo``: what others sent half a step on."""
        self._mid[self._halo] = halo
        self._next, share = self._parents.advance(self._flow, self._here, self._mid, dtau, size)
        return share, self._next[self._sent]

    def accept(self, halo: Floats) -> Standing:
        """Take the step; ``halo``: what others sent of its end."""
        self._next[self._halo] = halo
        self._here, self._steps = self._parents.standing(self._next), self._steps + 1
        self._kept[self._steps] = self._next
        return self.report()

    def states(self, step: int) -> Floats:
        """(r,) the own states after ``step`` steps, of those that are still kept."""
        return self._kept[step][: self._n_rows]
