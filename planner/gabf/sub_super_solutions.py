"""States that no run exceeds, or falls below: upper and lower solutions of the equation in tau, step by step."""

from __future__ import annotations

import math

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.gabf.assumptions import Premises, ceiling
from planner.gabf.flows import Flow
from planner.gabf.parents import parents_of
from planner.gabf.problem import Problem

_SPARE = 1.05
"""Farther than expected from the last step that the next one is held: nearer is tighter, and fails more often."""

_SWEEPS = 32
_TIGHTER = 16
_FEW, _FEW_OF = 0.25, 4_000
"""Share of the rows up to which it is faster to look only at those that read a changed state, and of how many rows."""


def limit(problem: Problem, y0: Floats, y_star: Floats, upper: bool) -> Floats:
    """(R + S,) states z with m(z) <= z, y0 <= z, which no run from ``y0`` exceeds (with >=: falls below).

    The least (largest) of them is x* itself, ``y_star``, where ``y0`` is nowhere above (below) it.
    """
    if (y0 <= y_star if upper else y0 >= y_star).all():
        return y_star
    worse = np.maximum if upper else np.minimum
    z = ceiling(problem, y0) if upper else y0
    for _ in range(problem.n_rows):
        swept = problem.with_sources(worse(y0[: problem.n_rows], problem.parent_values(z)))
        if np.array_equal(swept, z):
            break
        z = swept
    return z


class Side:
    """An upper (or lower) solution: states ``y`` (R + S,) at ``tau`` that no run from ``y0`` exceeds (falls below).

    The right side of a node's equation increases with every parent's state (the law is cooperative), so runs keep
    their order, and parents held too high (low) over a step give states that are too high (low). Where parents fall
    that is their value at the start of the step; where they rise it is a guess ``reach`` of how far, which is proved
    by the step itself: if no state goes farther with parents held there, none does at all. First order in the step.
    ``beyond`` (R + S,) are states that no run goes beyond, see :func:`limit`.
    """

    def __init__(self, problem: Problem, flow: Flow, y0: Floats, bounds: Premises, upper: bool, beyond: Floats):
        self.tau, self.y, self.sign, self.steps = 0.0, y0, 1.0 if upper else -1.0, 0
        self._problem, self._rows = problem, slice(0, problem.n_rows)
        self._flow, self._values, self._upper = flow, parents_of(problem), upper
        self._speed = self._expected = np.zeros(problem.n_rows)
        self._contracts = bounds.L <= 1.0 and not bounds.sampled  # between samples a kernel may be steeper
        self._limit = beyond[self._rows]

    @property
    def first_step(self) -> float:
        """A tenth of the time in which the fastest node would move by its own disequilibrium."""
        largest = float(np.abs(self.y[self._rows] - self._values(self.y)).max(initial=0.0))
        return 0.1 * largest / min(self._flow.speed(largest), 1e300) if largest else math.inf

    @np.errstate(over="ignore")
    def step(self, dtau: float) -> None:
        """Go on by ``dtau``."""
        there = self._from_speed(dtau)
        there = self._within_limit(self._from_fastest(dtau) if there is None else there, self._limit)
        speed = self._outwards(self.y[self._rows], there)
        np.maximum(speed, 0.0, out=speed)
        speed /= dtau
        slowing = np.divide(speed, self._speed, out=np.ones_like(speed), where=speed < self._speed)
        self._speed, self._expected = speed, speed * slowing
        self.tau, self.y = self.tau + dtau, np.concatenate((there, self.y[there.size :]))
        self.steps += 1

    def stays(self, y_star: Floats) -> bool:
        """Whether no state ever leaves max(y, y_star) (min on the lower side): it is an upper solution that rests."""
        worse = np.maximum(self.y, y_star) if self._upper else np.minimum(self.y, y_star)
        own = worse[self._rows]
        return bool((self.sign * (self._values(worse) - own) <= 4e-16 * np.maximum(1.0, np.abs(own))).all())

    def _from_speed(self, dtau: float) -> Floats | None:
        """Where the states get if they go on as in the last step, slowing down as before; None if it is not proved.

        A state that goes farther than guessed is held farther out, and those that read it are looked at again.
        """
        here = self.y[self._rows]
        reach = _SPARE * dtau * self._expected
        fixed = self._fixed(reach)
        there = self._flown(here, self._values(fixed), dtau)
        for _ in range(_SWEEPS):
            moved = self._outwards(here, there)
            short = np.flatnonzero(moved > reach)
            if not short.size:
                return there
            reach[short] = _SPARE * moved[short]
            fixed[short] = self._within_limit(here[short] + self.sign * reach[short], self._limit[short])
            if here.size < _FEW_OF or short.size > _FEW * here.size:
                there = self._flown(here, self._values(fixed), dtau)
            else:
                reading = self._reading(short)
                again = np.flatnonzero(reading)
                there[again] = self._flown(here[again], self._values.of(again, reading)(fixed), dtau)
        return None

    def _from_fastest(self, dtau: float) -> Floats:
        """How far the states get if each moves as far as the fastest one, or to the limit.

        The fastest never becomes faster if L <= 1. What this proves is used to repeat the step, as long as it gains.
        """
        here = self.y[self._rows]
        reach = self._outwards(here, self._limit)
        if self._contracts:
            fastest = float(np.max(self.sign * (self._values(self.y) - here), initial=0.0))
            reach = np.minimum(reach, dtau * self._flow.speed(fastest))
        there = self._flown(here, self._values(self._fixed(reach)), dtau)
        for _ in range(_TIGHTER):
            moved = self._outwards(here, there)
            if (moved >= 0.99 * reach).all():
                break
            reach = np.minimum(reach, np.maximum(moved, 0.0))
            there = self._flown(here, self._values(self._fixed(reach)), dtau)
        return there

    def _outwards(self, here: Floats, there: Floats) -> Floats:
        """How far ``there`` is beyond ``here``."""
        return there - here if self._upper else here - there

    def _fixed(self, reach: Floats) -> Floats:
        """The states, each ``reach`` (R,) outwards."""
        fixed = self.y.copy()
        if reach.any():
            fixed[self._rows] = self._within_limit(fixed[self._rows] + self.sign * reach, self._limit)
        return fixed

    def _reading(self, rows: Ints) -> Bools:
        """(R,) which rows read one of ``rows``."""
        reading = np.zeros(self._problem.n_rows, dtype=bool)
        reading[self._problem.owners[self._problem.readers.of(rows)]] = True
        return reading

    def _within_limit(self, y: Floats, beyond: Floats) -> Floats:
        return np.minimum(y, beyond) if self._upper else np.maximum(y, beyond)

    def _flown(self, here: Floats, m: Floats, dtau: float) -> Floats:
        """Where states ``here`` get in ``dtau`` with parent values ``m``, at most (at least)."""
        s = here - m
        falling, rising = self._flow.slowest, self._flow.fastest
        if not self._upper:
            falling, rising = rising, falling
        left, below = falling(s, dtau), np.flatnonzero(s < 0)
        if below.size:
            left[below] = rising(s[below], dtau)
        there = m + left
        held = np.flatnonzero((there == here) & (self.sign * s < 0.0))  # or rounding would hold them inside for ever
        there[held] = np.nextafter(here[held], m[held])
        return there
