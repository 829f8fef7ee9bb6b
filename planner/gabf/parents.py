"""min_j f_i(y_j, w_ij) over the rows that still move: the only part of a step that reads the graph."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.gabf.arcmaps import AffineArcs, ArcMap
from planner.gabf.problem import Rows

GROUP_FROM = 5_000
"""Rows from which grouping by degree is faster than one reduceat (at 1e5 rows 17 against 40 ns a row)."""


class Parents(Protocol):
    """Parent values of the ``rows`` that still move; :meth:`retire` drops those that never will again."""

    @property
    def rows(self) -> Ints | slice: ...
    def __call__(self, y: Floats) -> Floats: ...
    def lowest_moving(self, y: Floats, xhat: Floats) -> float: ...
    def retire(self, y: Floats, xhat: Floats, least: float) -> Parents: ...


def parents_of(problem: Rows) -> Parents:
    """Parent values of all rows, laid out for their number and kernel."""
    if problem.n_rows == 0:
        return AllRows(problem)
    if problem.n_rows >= GROUP_FROM:
        return by_degree(problem)
    return padded(problem) or AllRows(problem)


@dataclass(frozen=True, eq=False)
class AllRows:
    """Every row in one call, for small problems, where calls cost more than arithmetic."""

    problem: Rows

    @property
    def rows(self) -> slice:
        return slice(0, self.problem.n_rows)

    def __call__(self, y: Floats) -> Floats:
        return self.problem.parent_values(y)

    def lowest_moving(self, y: Floats, xhat: Floats) -> float:
        return lowest_moving(y[: xhat.size], xhat)

    def retire(self, y: Floats, xhat: Floats, least: float) -> AllRows:
        return self


@dataclass(frozen=True, eq=False)
class Padded(AllRows):
    """Every row filled up to the largest degree with arcs of infinite cost: half the time of a reduceat at 1e3."""

    heads: Ints
    slope: Floats | None
    offset: Floats

    def __call__(self, y: Floats) -> Floats:
        values = y.take(self.heads, mode="clip")
        if self.slope is not None:
            values *= self.slope
        values += self.offset
        return np.minimum.reduce(values, axis=0)


def padded(problem: Rows) -> Padded | None:
    """None where it does not pay: a kernel that is not affine, or degrees that differ too much."""
    degree = np.diff(problem.starts, append=problem.heads.size)
    width, arcs = int(degree.max(initial=0)), problem.arcs
    if not isinstance(arcs, AffineArcs) or width * degree.size > 3 * problem.heads.size:
        return None
    place = np.arange(problem.heads.size) - problem.starts[problem.owners], problem.owners
    heads, offset = np.zeros((width, degree.size), dtype=np.intp), np.full((width, degree.size), np.inf)
    heads[place], offset[place] = problem.heads, arcs.offset
    slope = None
    if arcs.slope is not None:
        slope = np.ones_like(offset)
        slope[place] = arcs.slope
    return Padded(problem, heads, slope, offset)


@dataclass(frozen=True, eq=False)
class Group:
    """Rows of equal degree k: ``heads`` (k, rows), so that their minimum runs along whole columns."""

    rows: Ints
    heads: Ints
    arcs: ArcMap

    def __call__(self, y: Floats) -> Floats:
        return self.arcs(y.take(self.heads, mode="clip").ravel()).reshape(self.heads.shape).min(axis=0)

    def keep(self, kept: Bools) -> Group:
        columns = np.broadcast_to(kept, self.heads.shape).ravel()
        return Group(self.rows[kept], self.heads[:, kept], self.arcs.take(columns))


@dataclass(frozen=True, eq=False)
class ByDegree:
    """The moving rows of a large problem, grouped by degree."""

    groups: list[Group]
    rows: Ints

    def __call__(self, y: Floats) -> Floats:
        return np.concatenate([group(y) for group in self.groups]) if self.groups else np.empty(0)

    def lowest_moving(self, y: Floats, xhat: Floats) -> float:
        return lowest_moving(y[self.rows], xhat[self.rows])

    def retire(self, y: Floats, xhat: Floats, least: float) -> ByDegree:
        """Drop the rows that rest for good, once they are a quarter of all.

        Let v = ``least`` be :meth:`lowest_moving`, of all rows of the network. Rows at rest below v read only rows at
        rest below v, and no state falls below v any more: the moving row that is lowest has parent values of at least
        v. So they never move again; this is lemma (globalbound) applied to the rest of the network.
        """
        s, here = xhat[self.rows], y[self.rows]
        moving = s != 0
        kept = moving | (here >= least)
        if not kept.size or kept.sum() > 0.75 * kept.size:
            return self
        ends = np.cumsum([group.rows.size for group in self.groups])[:-1]
        groups = [g.keep(k) for g, k in zip(self.groups, np.split(kept, ends), strict=True) if k.any()]
        return ByDegree(groups, self.rows[kept])


def lowest_moving(here: Floats, s: Floats) -> float:
    """The least of y and m over the rows with s = y - m other than 0; +inf where none moves."""
    moving = s != 0
    return float(np.minimum(here, here - s)[moving].min(initial=np.inf))


def by_degree(problem: Rows) -> ByDegree:
    degree = np.diff(problem.starts, append=problem.heads.size)
    groups = [_group(problem, np.flatnonzero(degree == k), int(k)) for k in np.unique(degree)]
    return ByDegree(groups, np.concatenate([group.rows for group in groups]))


def _group(problem: Rows, rows: Ints, degree: int) -> Group:
    arcs = problem.starts[rows] + np.arange(degree)[:, None]
    return Group(rows, problem.heads[arcs], problem.arcs.take(arcs.ravel()))
