"""The kernel bound to the arcs of one network: a vector of functions a -> f_i(a, w_ij), one per arc."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import AssumptionError

UserFunction = Callable[[Ints, Floats, Floats], Floats]

SAMPLES = 33
"""Values of a at which a user's kernel is probed first; more follow where its slope changes."""

_MOST_SAMPLES = 400
_STEADY = 0.01  # of a slope: by less, neighbouring pieces count as one


class ArcMap(Protocol):
    """What solvers and checks ask of the bound kernel; arrays run over the arcs."""

    @property
    def sampled(self) -> bool: ...
    def __call__(self, a: Floats) -> Floats: ...
    def take(self, arcs: Ints | Bools) -> ArcMap: ...
    def progress(self, lower: float, upper: float) -> Floats: ...
    def slopes(self, lower: float, upper: float) -> tuple[Floats, Floats]: ...


@dataclass(frozen=True, eq=False)
class AffineArcs:
    """f_ij(a) = slope_ij a + offset_ij; ``slope`` is None where every slope is 1 (the additive family)."""

    slope: Floats | None
    offset: Floats
    sampled: bool = False

    def __call__(self, a: Floats) -> Floats:
        return a + self.offset if self.slope is None else self.slope * a + self.offset

    def take(self, arcs: Ints | Bools) -> AffineArcs:
        return AffineArcs(None if self.slope is None else self.slope[arcs], self.offset[arcs])

    def progress(self, lower: float, upper: float) -> Floats:
        """Smallest f_ij(a) - a over a in [lower, upper] per arc: zeta of eq. (progressive).

        Exact, as an affine map has it at one of the two ends.
        """
        if self.slope is None:
            return self.offset
        gains = (self.slope - 1.0) * np.array([[lower], [upper]]) + self.offset
        return gains.min(axis=0)

    def slopes(self, lower: float, upper: float) -> tuple[Floats, Floats]:
        """Smallest and largest slope of each f_ij on [lower, upper]."""
        slope = np.ones_like(self.offset) if self.slope is None else self.slope
        return slope, slope


@dataclass(frozen=True, eq=False)
class FunctionArcs:
    """A user's f(i, a, b), vectorised over arcs; its properties are sampled, not proved."""

    function: UserFunction
    tails: Ints
    weight: Floats
    sampled: bool = True

    def __call__(self, a: Floats) -> Floats:
        values = np.asarray(self.function(self.tails, a, self.weight), dtype=np.float64)
        if values.shape != a.shape:
            raise AssumptionError(
                f"the user kernel returned shape {values.shape} for arcs of shape {a.shape}: f(i, a, b) must work "
                "on arrays, one value an arc"
            )
        return values

    def take(self, arcs: Ints | Bools) -> FunctionArcs:
        return FunctionArcs(self.function, self.tails[arcs], self.weight[arcs])

    def progress(self, lower: float, upper: float) -> Floats:
        """Smallest f_ij(a) - a over the sampled a in [lower, upper], arc by arc."""
        grid, values = self._table(lower, upper)
        return (values - grid[:, None]).min(axis=0)

    def slopes(self, lower: float, upper: float) -> tuple[Floats, Floats]:
        """Smallest and largest difference quotient of each f_ij between neighbouring samples."""
        grid, values = self._table(lower, upper)
        if len(grid) == 1:
            return np.ones_like(self.weight), np.ones_like(self.weight)
        quotients = np.diff(values, axis=0) / np.diff(grid)[:, None]
        return quotients.min(axis=0), quotients.max(axis=0)

    def _table(self, lower: float, upper: float) -> tuple[Floats, Floats]:
        """Samples (k,), denser where slopes change, and every arc's value at each (k, arcs)."""
        grid = np.unique(np.linspace(lower, upper, SAMPLES))
        values = self._at(grid)
        finest = 1e-9 * (upper - lower)
        while len(grid) > 1:
            gaps = np.diff(grid)
            bent = _bent(np.diff(values, axis=0) / gaps[:, None]) & (gaps > finest)
            if not bent.any() or len(grid) + np.count_nonzero(bent) > _MOST_SAMPLES:
                break
            middles = grid[:-1][bent] + 0.5 * gaps[bent]
            grid = np.concatenate([grid, middles])
            values = np.concatenate([values, self._at(middles)])
            order = np.argsort(grid)
            grid, values = grid[order], values[order]
        return grid, values

    def _at(self, grid: Floats) -> Floats:
        return np.stack([self(np.full(self.weight.shape, a)) for a in grid])


def _bent(slopes: Floats) -> Bools:
    """Which pieces (k, arcs) have a slope unlike that of a neighbouring piece, on any arc."""
    change = np.abs(np.diff(slopes, axis=0)) > _STEADY * np.maximum(np.abs(slopes[:-1]), np.abs(slopes[1:]))
    ends = change.any(axis=1)
    return np.concatenate([ends, [False]]) | np.concatenate([[False], ends])
