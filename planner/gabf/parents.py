"""min_j f_i(y_j, w_ij) over the rows that still move: the only part of a step that reads the graph."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.gabf.arcmaps import AffineArcs
from planner.gabf.flows import Flow
from planner.gabf.problem import Rows, Standing
from planner.native.compiled import NativeArcs


class Parents(ABC):
    """Parent values of the ``rows`` that still move, None for all, and steps of the splitting method by them.

    Rows that rest cost no power, and those that :meth:`retire` drops nothing.
    """

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

    def step(self, flow: Flow, at: Standing, dtau: float, size: float) -> tuple[Standing, float]:
        """How the rows stand after ``dtau``, and how far off that may be: :meth:`sketch`, then :meth:`advance`."""
        y, off = self.advance(flow, at, self.sketch(flow, at, dtau, size), dtau, size)
        return self.standing(y), off

    def sketch(self, flow: Flow, at: Standing, dtau: float, size: float) -> Floats:
        """y (R + S,) about half a step on, where parent values are taken from, see :meth:`Flow.half_step`."""
        y_mid = at.y.copy()
        flow.compiled.sketch(self.rows, at.y, at.xhat, flow.half_step(dtau, size), y_mid)
        return y_mid

    def advance(self, flow: Flow, at: Standing, y_mid: Floats, dtau: float, size: float) -> tuple[Floats, float]:
        """y after ``dtau``, and how far off the step may be, as a share of ``size`` + |xhat_i|; ``y_mid`` is used up.

        Had m not been moved by delta, the step would have ended delta (1 - rho) elsewhere, rho the share of
        y_i - m_i that the flow leaves over. The law undoes an error of ``size`` in size / phi(size), so this
        share counts as a time: ``size`` is the largest disequilibrium, or an average arc cost if smaller.
        """
        return y_mid, flow.compiled.advance(self.rows, self(y_mid), at.y, at.xhat, dtau, size, y_mid)

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

    def step(self, flow: Flow, at: Standing, dtau: float, size: float) -> tuple[Standing, float]:
        half = flow.half_step(dtau, size)
        y, xhat, *numbers, off = self._arcs.step(flow.compiled, self.rows, at.y, at.xhat, half, dtau, size)
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
