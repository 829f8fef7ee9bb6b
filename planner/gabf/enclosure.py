"""When a law settles, proved: upper and lower solutions that the true states stay between, from any start."""

from __future__ import annotations

import math

import numpy as np

from planner.base.arrays import Floats
from planner.gabf.assumptions import Premises, ceiling, start_above
from planner.gabf.flows import Flow
from planner.gabf.parents import parents_of
from planner.gabf.problem import Problem

WIDTH = 0.5
"""Share of the latest settling tau that a bracket may be wide before it is computed again with smaller steps.

On a roadmap of 1000 nodes it takes twice the work of a run, of 100,000 nodes five times; at 0.1 six and fifty times.
"""

_STEPS = 64
_ROUNDS = 6
_MOST_STEPS = 40_000
"""Steps of one side in one round: a rise over X at arcs of cost c takes X / c at least."""

_BLUR = 64 * np.finfo(float).eps
"""Rounding of a state, relative to max(1, |x*|), that counts for neither side of a band; 1e-5 of the default one."""

_ROUNDING = 1e-9

_SPARE = 1.1
"""Farther than the last step that the next one is guessed to reach."""

_SWEEPS = 4
_TIGHTER = 16
_RAMP = 16.0
"""Early steps change states that fall from far away by this many times a later step's share of the whole: they fall as
a power of tau, from 17 to 1 within 1e-120 where an exponent is 99.
"""


def bracket_settling(
    problem: Problem,
    flow: Flow,
    y0: Floats,
    bounds: Premises,
    tolerance: float,
    guess: float,
    width: float = WIDTH,
) -> tuple[float, float]:
    """The earliest and the latest tau at which every error can have entered its band for good.

    ``tolerance`` defines the band as in :func:`planner.gabf.solve`; ``guess`` is where to expect the answer and
    decides about the work only. Steps shrink until the bracket is ``width`` of its end, or the work is spent: a
    smaller width takes proportionally more. The latest is +inf where the lower solution is not there within the work.
    Proved up to rounding, for every increasing kernel.
    """
    y_star = _optimum(problem)
    earliest, latest = 0.0, math.inf
    whole = guess or flow.pace
    dtau = whole / _STEPS
    for _ in range(_ROUNDS):
        sides = [_Side(problem, flow, y0, bounds, upper) for upper in (True, False)]
        ramp = math.expm1(min(_RAMP * dtau / whole * flow.far_power, 30.0))
        dates = [_dates(side, y_star, tolerance, dtau, ramp) for side in sides]
        earliest = max(earliest, *(outside * (1.0 - _ROUNDING) for outside, _ in dates))
        latest = min(latest, max(inside * (1.0 + _ROUNDING) for _, inside in dates))
        if math.isinf(latest) or latest - earliest <= width * latest:
            break
        dtau *= min(0.5, max(0.125, 0.8 * width * latest / (latest - earliest)))
    return earliest, latest


def _optimum(problem: Problem) -> Floats:
    """x*, from above: as many sweeps of eq. (bellman-gabf) as there are rows suffice."""
    y = start_above(problem)
    while True:
        swept = np.concatenate((problem.parent_values(y), problem.anchors))
        if np.array_equal(swept, y):
            return y
        y = swept


def _dates(side: _Side, y_star: Floats, tolerance: float, dtau: float, ramp: float) -> tuple[float, float]:
    """Two tau: the last at which this side proves a state outside its band, and the first after which none leaves it.

    "Leaves" means on this side only, and is proven too.
    """
    scale = np.maximum(1.0, np.abs(y_star))
    band, blur = tolerance * scale, min(0.01 * tolerance, _BLUR) * scale
    outside, inside = 0.0, math.inf
    first = min(side.first_step, dtau)
    for _ in range(_MOST_STEPS):
        beyond = side.sign * (side.y - y_star)
        within = bool((beyond <= band - blur).all())
        if not within:
            inside = math.inf
        elif math.isinf(inside) and side.stays(y_star):
            inside = side.tau
        short = bool((beyond < -band - blur).any())
        if short:
            outside = side.tau
        elif math.isfinite(inside):
            break
        side.step(min(dtau, max(first, ramp * side.tau)))
    return outside, inside


def _limit(problem: Problem, y0: Floats, upper: bool) -> Floats:
    """(R + S,) states z with m(z) <= z, y0 <= z, which no run from ``y0`` exceeds (with >=: falls below)."""
    worse = np.maximum if upper else np.minimum
    z = ceiling(problem, y0) if upper else y0
    for _ in range(problem.n_rows):
        swept = np.concatenate((worse(y0[: problem.n_rows], problem.parent_values(z)), problem.anchors))
        if np.array_equal(swept, z):
            break
        z = swept
    return z


class _Side:
    """An upper (or lower) solution: states ``y`` (R + S,) at ``tau`` that no run from ``y0`` exceeds (falls below).

    The right side of a node's equation increases with every parent's state (the law is cooperative), so runs keep
    their order, and parents held too high (low) over a step give states that are too high (low). Where parents fall
    that is their value at the start of the step; where they rise it is a guess ``reach`` of how far, which is proved
    by the step itself: if no state goes farther with parents held there, none does at all. First order in the step.
    """

    def __init__(self, problem: Problem, flow: Flow, y0: Floats, bounds: Premises, upper: bool):
        self.tau, self.y, self.sign = 0.0, y0, 1.0 if upper else -1.0
        self._flow, self._parents, self._upper = flow, parents_of(problem), upper
        self._speed = np.zeros(problem.n_rows)
        self._contracts = bounds.L <= 1.0
        self._limit = _limit(problem, y0, upper)[self._parents.where]

    @property
    def first_step(self) -> float:
        """A tenth of the time in which the fastest node would move by its own disequilibrium."""
        rows = self._parents.where
        largest = float(np.abs(self.y[rows] - self._parents(self.y)).max(initial=0.0))
        return 0.1 * largest / min(self._flow.speed(largest), 1e300) if largest else math.inf

    def step(self, dtau: float) -> None:
        """Go on by ``dtau``."""
        rows = self._parents.where
        there = self._from_speed(dtau)
        y = self.y.copy()
        y[rows] = self._within_limit(self._from_fastest(dtau) if there is None else there)
        self._speed = np.maximum(self.sign * (y[rows] - self.y[rows]), 0.0) / dtau
        self.tau, self.y = self.tau + dtau, y

    def stays(self, y_star: Floats) -> bool:
        """Whether no state ever leaves max(y, y_star) (min on the lower side): it is an upper solution that rests."""
        worse = np.maximum(self.y, y_star) if self._upper else np.minimum(self.y, y_star)
        own = worse[self._parents.where]
        return bool((self.sign * (self._parents(worse) - own) <= 4e-16 * np.maximum(1.0, np.abs(own))).all())

    def _from_speed(self, dtau: float) -> Floats | None:
        """Where the states get if none goes much farther than in the last step; None if that is not proved."""
        reach = _SPARE * dtau * self._speed
        for _ in range(_SWEEPS):
            there, moved = self._try(reach, dtau)
            if (moved <= reach).all():
                return there
            reach = np.where(moved <= reach, reach, _SPARE * moved)
        return None

    def _from_fastest(self, dtau: float) -> Floats:
        """How far the states get if each moves as far as the fastest one, or to the limit.

        The fastest never becomes faster if L <= 1. What this proves is used to repeat the step, as long as it gains.
        """
        rows = self._parents.where
        reach = self.sign * (self._limit - self.y[rows])
        if self._contracts:
            fastest = float(np.max(self.sign * (self._parents(self.y) - self.y[rows]), initial=0.0))
            reach = np.minimum(reach, dtau * self._flow.speed(fastest))
        there, moved = self._try(reach, dtau)
        for _ in range(_TIGHTER):
            if (moved >= 0.99 * reach).all():
                break
            reach = np.minimum(reach, np.maximum(moved, 0.0))
            there, moved = self._try(reach, dtau)
        return there

    def _try(self, reach: Floats, dtau: float) -> tuple[Floats, Floats]:
        """Where each state gets in ``dtau`` with its parents held ``reach`` outwards, and how far outwards that is."""
        rows = self._parents.where
        held, here = self.y.copy(), self.y[rows]
        held[rows] = self._within_limit(here + self.sign * reach)
        m = self._parents(held)
        there = m + self._outermost(here - m, dtau)
        return there, self.sign * (there - here)

    def _within_limit(self, y: Floats) -> Floats:
        return np.minimum(y, self._limit) if self._upper else np.maximum(y, self._limit)

    def _outermost(self, s: Floats, dtau: float) -> Floats:
        flow = self._flow
        above, below = (flow.slowest, flow.fastest) if self._upper else (flow.fastest, flow.slowest)
        if (s >= 0).all():
            return above(s, dtau)
        if (s <= 0).all():
            return below(s, dtau)
        return np.where(s > 0, above(s, dtau), below(s, dtau))
