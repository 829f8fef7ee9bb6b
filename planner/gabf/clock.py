"""The two times of the paper: t on the wall, and tau, in which every law is autonomous."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from planner.base.arrays import Floats

Reading: TypeAlias = float | Floats
"""One reading of a clock, or an array of them."""


@dataclass(frozen=True)
class UniformClock:
    """tau = eta t: the clock of laws without a prescribed time; a larger ``eta`` is faster in t."""

    eta: float

    def tau(self, t: Reading) -> Floats:
        return self.eta * np.asarray(t, dtype=np.float64)

    def time(self, tau: Reading) -> Floats:
        return np.asarray(tau, dtype=np.float64) / self.eta

    def log_gain(self, tau: Reading) -> Floats:
        """ln(d tau / dt)."""
        return np.full(np.shape(tau), math.log(self.eta))

    def log10_remaining(self, tau: float) -> float | None:
        return None


@dataclass(frozen=True)
class PrescribedClock:
    """tau(t) = gamma t - 2 (1 + h) ln((T_p - t) / T_p), eq. (ts): all of [0, inf) squeezed into [0, T_p).

    Its rate is etabar(t) = gamma + 2 (1 + h) / (T_p - t) of eq. (ebar). Larger ``gamma`` and ``h`` reach a
    given tau earlier, with a larger gain. From tau of about gamma T + 74 (1 + h) on no double t < T_p is
    left, so tau and log10(T_p - t) are the record, and t rounds to T_p.
    """

    T: float
    h: float
    gamma: float

    def tau(self, t: Reading) -> Floats:
        """tau at times t; +inf from T_p on. Near 0 the share of T_p that is left rounds to 1, near T_p t / T_p does."""
        t = np.asarray(t, dtype=np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            log_share = np.where(t < 0.5 * self.T, np.log1p(-t / self.T), np.log((self.T - t) / self.T))
            tau = self.gamma * t - 2.0 * (1.0 + self.h) * log_share
        return np.where(t >= self.T, np.inf, tau)

    def time(self, tau: Reading) -> Floats:
        return 0.0 - self.T * np.expm1(self._log_share(tau))

    def log_gain(self, tau: Reading) -> Floats:
        """ln etabar, eq. (ebar): finite at every finite tau; -inf from T_p on, where the gain is 0."""
        log_share = self._log_share(tau)
        growing = math.log(2.0 * (1.0 + self.h) / self.T) - log_share
        return np.where(np.isinf(tau), -np.inf, np.logaddexp(math.log(self.gamma), growing))

    def log10_remaining(self, tau: float) -> float | None:
        """log10(T_p - t), finite for every finite tau."""
        return float((math.log(self.T) + self._log_share(tau)) / math.log(10.0))

    def _log_share(self, tau: Reading) -> Floats:
        """l = ln((T_p - t) / T_p), the root of gamma T (1 - e^l) - 2 (1 + h) l = tau.

        Newton from above, 1 - e^l being less than -l and than 1: the left side is decreasing and concave, so the
        iterates fall monotonically to the root.
        """
        tau = np.asarray(tau, dtype=np.float64)
        endless = np.isinf(tau)
        reading = np.where(endless, 0.0, tau)
        slope, drift = 2.0 * (1.0 + self.h), self.gamma * self.T
        share = np.minimum(-reading / (drift + slope), (drift - reading) / slope)
        with np.errstate(under="ignore"):  # e^l is 0 long before l ends, whatever the user asks NumPy to raise
            for _ in range(100):
                miss = -drift * np.expm1(share) - slope * share - reading
                share = share + miss / (drift * np.exp(share) + slope)
                if np.all(np.abs(miss) <= 4e-16 * (1.0 + reading)):
                    break
        return np.where(endless, -np.inf, share)
