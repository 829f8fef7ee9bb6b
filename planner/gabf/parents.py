"""min_j f_i(y_j, w_ij) over the rows that still move: the only part of a step that reads the graph."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.gabf.arcmaps import AffineArcs
from planner.gabf.problem import Rows
from planner.native.library import least_over_arcs

FEWER_ROWS_FROM = 5_000
"""Rows from which it pays to leave out those that rest for good: choosing some rows of an array has its price too."""


class Parents(Protocol):
    """Parent values of the ``rows`` that still move; :meth:`retire` drops those that never will again."""

    @property
    def rows(self) -> Ints | slice: ...
    def __call__(self, y: Floats) -> Floats: ...
    def lowest_moving(self, y: Floats, xhat: Floats) -> float: ...
    def retire(self, y: Floats, xhat: Floats, least: float) -> Parents: ...


def parents_of(problem: Rows) -> Parents:
    """All rows of a problem: compiled where arcs are affine, else by the kernel that the user wrote."""
    return AffineRows.of(problem) if isinstance(problem.arcs, AffineArcs) else AllRows(problem)


@dataclass(frozen=True, eq=False)
class AllRows:
    """Every row, through a kernel that is called with all arcs at once."""

    problem: Rows

    @property
    def rows(self) -> slice:
        return slice(0, self.problem.n_rows)

    def __call__(self, y: Floats) -> Floats:
        return self.problem.parent_values(y)

    def lowest_moving(self, y: Floats, xhat: Floats) -> float:
        return _lowest_moving(y[: xhat.size], xhat)

    def retire(self, y: Floats, xhat: Floats, least: float) -> AllRows:
        return self


@dataclass(frozen=True, eq=False)
class AffineRows:
    """The ``moving`` rows (k,) of a problem whose row i has the arcs ``first[i]`` to ``first[i + 1]``."""

    moving: Ints
    first: Ints
    heads: Ints
    arcs: AffineArcs

    @staticmethod
    def of(problem: Rows) -> AffineRows:
        assert isinstance(problem.arcs, AffineArcs)
        first = np.append(problem.starts, problem.heads.size)
        return AffineRows(np.arange(problem.n_rows), first, problem.heads, problem.arcs)

    @property
    def rows(self) -> Ints | slice:
        whole = self.moving.size == self.first.size - 1
        return slice(0, self.moving.size) if whole else self.moving

    def __call__(self, y: Floats) -> Floats:
        return least_over_arcs(self.moving, self.first, self.heads, self.arcs.slope, self.arcs.offset, y)

    def lowest_moving(self, y: Floats, xhat: Floats) -> float:
        return _lowest_moving(y[: xhat.size][self.rows], xhat[self.rows])

    def retire(self, y: Floats, xhat: Floats, least: float) -> AffineRows:
        """Drop the rows that rest for good, once they are a quarter of all.

        Let v = ``least`` be :meth:`lowest_moving`, of all rows of the network. Rows at rest below v read only rows at
        rest below v, and no state falls below v any more: the moving row that is lowest has parent values of at least
        v. So they never move again; this is lemma (globalbound) applied to the rest of the network.
        """
        if self.first.size <= FEWER_ROWS_FROM:
            return self
        s, here = xhat[self.rows], y[: xhat.size][self.rows]
        kept = (s != 0) | (here >= least)
        return self if not kept.size or kept.sum() > 0.75 * kept.size else replace(self, moving=self.moving[kept])


def _lowest_moving(here: Floats, s: Floats) -> float:
    """The least of y and m over the rows with s = y - m other than 0; +inf where none moves."""
    moving = s != 0
    return float(np.minimum(here, here - s)[moving].min(initial=np.inf))
