"""Eq. (fixtime): T_* as printed, corrected and sharp, beside the time that a single node really takes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner import gabf
from planner.reproduce.laws.cases import M, P

FAR = 1e40
"""A start so high that the time from infinity down to it is negligible."""

# exponents far from 1, at which even twice the printed T_*, as theorem (fix) has it, is no bound
EXTREME = ((1, 9), (5, 1))

_STEPS = 400


@dataclass(frozen=True)
class ScalarTime:
    """Exponents ``p`` and ``m``, and tau for one node from afar to x*, beta1 = beta2 = 1: three bounds, one run."""

    p: tuple[int, int]
    m: tuple[int, int]

    @property
    def label(self) -> str:
        return "{}/{}, {}/{}".format(*self.p, *self.m)

    @property
    def law(self) -> gabf.FixedTime:
        return gabf.FixedTime(eta=1.0, p=self.p, m=self.m)

    @property
    def printed(self) -> float:
        return gabf.T_star_printed(self.law)

    @property
    def corrected(self) -> float:
        return gabf.T_star_corrected(self.law)

    @property
    def sharp(self) -> float:
        return gabf.T_star_sharp(self.law)

    @property
    def theorem(self) -> float:
        """Theorem (fix) for this one node with T_* as printed: 2 T_*, as T_f is negative from above."""
        return 2.0 * self.printed

    @cached_property
    def measured(self) -> float:
        """GABF's settling tau on one node that reads one source, by ``_STEPS`` equal steps."""
        link = gabf.Network(
            np.array([0, 0, 1]), np.array([0]), np.array([1e-9]), sources=np.array([0]), kernel=gabf.Additive()
        )
        solver = gabf.Splitting(tolerance=np.inf, max_step=self.sharp / _STEPS)
        run = gabf.solve(link, law=self.law, x0=FAR, solver=solver, settle_tolerance=1e-20)
        assert run.settling_tau is not None
        return run.settling_tau


def paper_times() -> tuple[ScalarTime, ...]:
    """The sixteen pairs of exponents of section (comparison)."""
    return tuple(ScalarTime(p, m) for p in P for m in M)


def extreme_time() -> ScalarTime:
    """p1/p2 = 1/9 and m1/m2 = 5."""
    return ScalarTime(*EXTREME)
