"""Flows of the scalar equations that the laws become while a node's parent value is constant."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import AssumptionError
from planner.gabf.kernels import call_on_arrays
from planner.native.compiled import BRAKE_THEN_SINK, SINK_THEN_BRAKE, STRANG, NativeFlow


class Flow(ABC):
    """s' = -phi(s), phi of the sign of s; compiled for many states, except for a user's phi."""

    @abstractmethod
    def rate(self, s: Floats) -> Floats:
        """Return phi(s)."""

    @abstractmethod
    def speed(self, size: float) -> float:
        """Return phi of one number >= 0; inf beyond the largest double, the least double below it."""

    @abstractmethod
    def time_between(self, start: float, end: float) -> float:
        """Return the tau that |s| takes from ``start`` down to ``end``."""

    @property
    def compiled(self) -> NativeFlow | None:
        """The same equation in the compiled library; None for a user's phi."""
        return None

    def move(self, order: int, s: Floats, dtau: float) -> Floats:
        """Return s after ``dtau``, the powers below and above 1 acting one after the other in an ``order``."""
        assert self.compiled is not None
        return self.compiled.moved(order, s, dtau)

    def advance(self, s: Floats, dtau: float) -> Floats:
        """Return s after ``dtau``, second order in ``dtau``, exact at s = 0."""
        return self.move(STRANG, s, dtau)

    def miss(self, s: Floats, left: Floats, dtau: float) -> Floats | float:
        """Return the error of ``left`` = :meth:`advance` that :meth:`longest_step` does not bound."""
        return 0.0

    def slowest(self, s: Floats, dtau: float) -> Floats:
        """Return a proved upper bound of |s| after ``dtau``, first order, with the sign of s; exact at 0.

        As beta1 s^p / (beta2 s^q) falls with s, the power below 1 takes less off where it acts first, at the larger s.
        """
        return self.move(SINK_THEN_BRAKE, s, dtau)

    def fastest(self, s: Floats, dtau: float) -> Floats:
        """Return a proved lower bound of |s| after ``dtau``, by the other order."""
        return self.move(BRAKE_THEN_SINK, s, dtau)

    @property
    def whole_time(self) -> float:
        """The tau in which any s of a double vanishes to less than any double, here for s' = -s."""
        return 1500.0

    @property
    def pace(self) -> float:
        """The unit of tau: s / phi(s), up to a factor of 2, where the two powers of the law balance."""
        return 1.0

    @property
    def far_power(self) -> float:
        """From far away s falls as tau^(-1/far_power); 1 where it falls exponentially at the pace."""
        return 1.0

    def longest_step(self, size: float) -> float:
        """Return the step at which the error of :meth:`advance` of |s| <= ``size`` is |s|; inf if exact."""
        return math.inf

    def urgency(self, size: float) -> float:
        """Return phi(s) / s at ``size`` times the pace, at most 2.5: the error of a step, in tolerances.

        Without it, runs with exponents far from 1 take 100 times as many steps.
        """
        return min(self.pace * self.speed(size) / size, 2.5)

    def half_step(self, dtau: float, size: float) -> float:
        """Return the time within a step at which its parent values are evaluated.

        It is half of a short step, more of a long one: a node forgets at about the rate phi(s) / s, so it ends nearer
        to where its parents were later in the step. Exact for steady parents under the linear laws. It halves the error
        of the settling tau under the default law.
        """
        forgotten = dtau * self.speed(size) / size if size else 0.0
        return dtau * (1.0 / -math.expm1(-forgotten) - 1.0 / forgotten if forgotten > 1e-4 else 0.5)


@dataclass(frozen=True)
class LinearFlow(Flow):
    """s' = -s: the nominal and the prescribed-time law in tau."""

    @property
    def compiled(self) -> NativeFlow:
        return NativeFlow(0.0, 0.0, 0.0, 0.0)

    def rate(self, s: Floats) -> Floats:
        return np.asarray(s)

    def speed(self, size: float) -> float:
        return size

    def time_between(self, start: float, end: float) -> float:
        return math.log(start / end)


@dataclass(frozen=True)
class UserFlow(Flow):
    """s' = -phi(s) of a phi that only its values describe, by the exponential midpoint rule.

    The equation is s' = -k s with k = phi(s) / s >= 0. A step takes k as constant, with its value half a step on, so no
    s grows or changes its sign, and a linear phi is exact.
    """

    phi: Callable[[Floats], Floats]

    @property
    def whole_time(self) -> float:
        return 1e100  # a power above 1 takes long

    def rate(self, s: Floats) -> Floats:
        values = call_on_arrays("rate", self.phi, s)
        wrong = (np.sign(values) != np.sign(s)) & ((values != 0.0) | (np.abs(s) >= 1e-9))  # powers underflow
        if wrong.any():
            error, speed = float(s[wrong][0]), float(values[wrong][0])
            raise AssumptionError(f"rate({error:g}) must have the sign of the error and be 0 at 0, got {speed:g}.")
        return values

    def speed(self, size: float) -> float:
        return max(float(self.rate(np.array([size]))[0]), math.ulp(0.0)) if size else 0.0

    def urgency(self, size: float) -> float:
        return 1.0

    @np.errstate(all="ignore")
    def _decay(self, s: Floats, at: Floats, dtau: float) -> Floats:
        """Return s after ``dtau`` at the constant phi(s) / s of the state ``at``; at 0 that of 1e-300."""
        at = np.copysign(np.maximum(np.abs(at), 1e-300), s)
        return s * np.exp(-dtau * (self.rate(at) / at))

    def move(self, order: int, s: Floats, dtau: float) -> Floats:
        return self._decay(s, self._decay(s, s, 0.5 * dtau), dtau)

    def miss(self, s: Floats, left: Floats, dtau: float) -> Floats:
        return np.abs(left - self._decay(s, s, dtau))

    def time_between(self, start: float, end: float) -> float:
        """Return the integral of s / phi(s) over ln s, by the trapezoidal rule; ``end`` > 0."""
        s = np.geomspace(end, start, 257)
        return float(np.trapezoid(s / self.rate(s), np.log(s)))


@dataclass(frozen=True)
class PowerFlow(Flow):
    """s' = -(beta1 |s|^p + beta2 |s|^q) sgn(s), 0 < p < 1 < q: the two fixed-time laws in tau.

    Each half has an exact flow: |s|^(1-p) falls linearly and reaches zero in finite time, |s|^-(q-1) grows linearly.
    Strang's rule composes them (half, full, half), second order in dtau, exact at s = 0.
    """

    beta1: float
    beta2: float
    p: Fraction
    q: Fraction

    @cached_property
    def _floats(self) -> tuple[float, float, float, float]:
        return float(self.p), float(self.q), float(1 - self.p), float(self.q - 1)

    @property
    def compiled(self) -> NativeFlow:
        return NativeFlow(self.beta1, self.beta2, *self._floats[2:])

    @property
    def whole_time(self) -> float:
        """The tau from infinity to 0: pi / ((q - p) sin(pi r)) beta1^(r - 1) beta2^-r, r = (1 - p)/(q - p)."""
        p, q, below, _ = self._floats
        r = below / (q - p)
        return math.pi / ((q - p) * math.sin(math.pi * r)) * self.beta1 ** (r - 1.0) * self.beta2**-r

    @property
    def _log_balance(self) -> float:
        """ln s where beta1 s^p = beta2 s^q."""
        p, q, _, _ = self._floats
        return (math.log(self.beta1) - math.log(self.beta2)) / (q - p)

    @property
    def log_pace(self) -> float:
        """ln of :attr:`pace`."""
        return self._floats[2] * self._log_balance - math.log(self.beta1)

    @property
    def pace(self) -> float:
        """s^(1-p) / beta1 where the powers are equal: 1 for beta1 = beta2 = 1."""
        return math.exp(self.log_pace)

    @property
    def far_power(self) -> float:
        return self._floats[3]

    def longest_step(self, size: float) -> float:
        """Return the longest step in tau that Strang's rule allows at a disequilibrium of ``size``.

        In units of pace / (q - p) its error depends on r = (1 - p)/(q - p) only. It vanishes below the balance of both
        powers: if r < 1/2, as s^((q - p)(1 - 2r)/2), and else zero is a few units away.
        """
        p, q, below, _ = self._floats
        width = q - p
        decades = width * (math.log(size) - self._log_balance) if size > 0 else -math.inf
        vanishing = min(0.5, max(0.0, 0.5 - below / width)) * min(decades, 0.0)
        return self.pace / width * math.exp(min(-vanishing, 700.0))

    def speed(self, size: float) -> float:
        p, q, _, _ = self._floats
        try:
            return max(self.beta1 * size**p + self.beta2 * size**q, math.ulp(0.0)) if size else 0.0
        except OverflowError:
            return math.inf

    @np.errstate(over="ignore")
    def rate(self, s: Floats) -> Floats:
        size, (p, q, _, _) = np.abs(s), self._floats
        return np.copysign(self.beta1 * size**p + self.beta2 * size**q, s)

    def time_between(self, start: float, end: float) -> float:
        """Return the tau that |s| takes from ``start`` down to ``end`` >= 0.

        With v = (q - p) ln(s / c), c where both powers are equal, tau is pace / (q - p) times the integral of e^(r v) /
        (1 + e^v), r = (1 - p)/(q - p). Below -40 and above 40 one power suffices to the last bit; between, ten Gauss
        points in each panel of width 2 leave an error below 1e-12, for any exponents.
        """
        p, q, below, above = self._floats
        width = q - p
        low, high = (width * (math.log(s) - self._log_balance) if s > 0 else -math.inf for s in (end, start))
        sink = _exponential_integral(below / width, min(low, -_FLAT), min(high, -_FLAT))
        brake = _exponential_integral(-above / width, max(low, _FLAT), max(high, _FLAT))
        low, high = max(low, -_FLAT), min(high, _FLAT)
        both = _two_power_integral(below / width, low, high) if low < high else 0.0
        return self.pace / width * (sink + both + brake)


_FLAT = 40.0
_GAUSS = np.polynomial.legendre.leggauss(10)


def _exponential_integral(rate: float, low: float, high: float) -> float:
    """Return the integral of e^(rate v); the end at which e^(rate v) vanishes may be infinite."""
    return 0.0 if low == high else (math.exp(rate * high) - math.exp(rate * low)) / rate


def _two_power_integral(rate: float, low: float, high: float) -> float:
    """Return the integral of e^(rate v) / (1 + e^v) between -40 and 40."""
    edges, (points, weights) = np.linspace(low, high, math.ceil(0.5 * (high - low)) + 1), _GAUSS
    half = 0.5 * np.diff(edges)
    v = 0.5 * (edges[1:] + edges[:-1])[:, None] + half[:, None] * points
    return float(half @ (np.exp(rate * v) / (1.0 + np.exp(v)) @ weights))
