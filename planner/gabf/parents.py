"""min_j f_i(y_j, w_ij) over the rows that still move: the only part of a step that reads the graph."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.gabf.arcmaps import AffineArcs
from planner.gabf.problem import Rows, Standing
from planner.native.dynamics import NativeArcs, NativeFlow


class Parents(ABC):
    """Parent values of the ``rows`` that still move, None for all; :meth:`retire` drops those that never will again."""

    def __init__(self, problem: Rows, rows: Ints | None) -> None:
        self.problem, self.rows = problem, rows

    @abstractmethod
    def __call__(self, y: Floats) -> Floats:
        """(rows,) m_i at states ``y``."""

    @abstractmethod
    def of(self, rows: Ints, kept: Bools) -> Parents:
        """The same for fewer ``rows``, those of the present ones that are ``kept``."""

    def standing(self, y: Floats) -> Standing:
        """How the rows stand at states ``y``; xhat is 0 at those that are not looked at."""
        xhat, rows = np.zeros(self.problem.n_rows), self.where
        xhat[rows] = y[rows] - self(y)
        return Standing.of(y, xhat)

    def step(self, flow: NativeFlow, at: Standing, half: float, dtau: float, size: float) -> tuple[Standing, float]:
        """How the rows stand after ``dtau``, and how far off that may be: :meth:`sketch`, then :meth:`advance`."""
        following, off = self.advance(flow, at, self.sketch(flow, at, half), dtau, size)
        return self.standing(following), off

    def sketch(self, flow: NativeFlow, at: Standing, half: float) -> Floats:
        """y (R + S,) after ``half``, where parent values are taken from."""
        y_mid = at.y.copy()
        flow.sketch(self.rows, at.y, at.xhat, half, y_mid)
        return y_mid

    def advance(self, flow: NativeFlow, at: Standing, y_mid: Floats, dtau: float, size: float) -> tuple[Floats, float]:
        """y (R + S,) after ``dtau``, in place of ``y_mid``, and how far off: see :meth:`Stepper.advance`."""
        return y_mid, flow.advance(self.rows, self(y_mid), at.y, at.xhat, dtau, size, y_mid)

    @property
    def where(self) -> Ints | slice:
        """The rows as an index of states."""
        return slice(0, self.problem.n_rows) if self.rows is None else self.rows

    def retire(self, at: Standing, least: float) -> Parents:
        """Drop the rows that rest for good, once they are a quarter of all.

        Let v = ``least`` be :attr:`Standing.lowest_moving`, of all rows of the network. Rows at rest below v read only
        rows at rest below v, and no state falls below v any more: the moving row that is lowest has parent values of at
        least v. So they never move again; this is lemma (globalbound) applied to the rest of the network.
        """
        kept = (at.xhat[self.where] != 0) | (at.y[self.where] >= least)
        if not kept.size or kept.sum() > 0.75 * kept.size:
            return self
        return self.of(np.flatnonzero(kept) if self.rows is None else self.rows[kept], kept)


def parents_of(problem: Rows) -> Parents:
    """Parent values of all rows, compiled where the kernel is affine."""
    if isinstance(problem.arcs, AffineArcs):
        arcs = problem.arcs
        return AffineParents(problem, None, NativeArcs(problem.starts, problem.heads, arcs.slope, arcs.offset))
    return UserParents(problem, None, problem)


class AffineParents(Parents):
    """Of the kernels of the paper."""

    def __init__(self, problem: Rows, rows: Ints | None, arcs: NativeArcs) -> None:
        super().__init__(problem, rows)
        self._arcs = arcs

    def __call__(self, y: Floats) -> Floats:
        return self._arcs.parent_values(self.rows, y)

    def standing(self, y: Floats) -> Standing:
        return Standing(y, *self._arcs.standing(self.rows, y))

    def step(self, flow: NativeFlow, at: Standing, half: float, dtau: float, size: float) -> tuple[Standing, float]:
        y, xhat, *numbers, off = self._arcs.step(flow, self.rows, at.y, at.xhat, half, dtau, size)
        return Standing(y, xhat, *numbers), off

    def of(self, rows: Ints, kept: Bools) -> Parents:
        return AffineParents(self.problem, rows, self._arcs)


class UserParents(Parents):
    """Of a kernel that is a Python function; ``moving`` are the rows left, as a problem of their own."""

    def __init__(self, problem: Rows, rows: Ints | None, moving: Rows) -> None:
        super().__init__(problem, rows)
        self._moving = moving

    def __call__(self, y: Floats) -> Floats:
        return self._moving.parent_values(y)

    def of(self, rows: Ints, kept: Bools) -> Parents:
        counts = np.diff(self._moving.starts, append=self._moving.heads.size)
        arcs, counts = np.repeat(kept, counts), counts[kept]
        moving = Rows(np.cumsum(counts) - counts, self._moving.heads[arcs], self._moving.arcs.take(arcs))
        return UserParents(self.problem, rows, moving)
