"""Exact flows of the scalar equations that the laws become while a node's parent value is held fixed."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property

import numpy as np

from planner.base.arrays import Floats


class Flow(ABC):
    """s' = -phi(s), phi odd and increasing."""

    @abstractmethod
    def rate(self, s: Floats) -> Floats:
        """phi(s)."""

    @abstractmethod
    def advance(self, s: Floats, dtau: float) -> Floats:
        """s after ``dtau``."""

    @abstractmethod
    def time_between(self, start: float, end: float) -> float:
        """tau that |s| takes from ``start`` down to ``end``."""

    @abstractmethod
    def slowest(self, size: Floats, dtau: float) -> Floats:
        """A proved upper bound of |s| after ``dtau``, first order in ``dtau``; ``size`` >= 0, exact at 0."""

    @abstractmethod
    def fastest(self, size: Floats, dtau: float) -> Floats:
        """A proved lower bound of |s| after ``dtau``, likewise."""

    @abstractmethod
    def sketch(self, s: Floats, dtau: float) -> Floats:
        """The same as :meth:`advance` to first order in ``dtau``, for less work; exact at s = 0."""

    @abstractmethod
    def resolvent(self, c: Floats, dtau: float) -> Floats:
        """The root s of s + dtau phi(s) = c: one backward Euler step."""

    @property
    def total_time(self) -> float:
        """tau from infinity down to 0; infinite for a linear flow."""
        return math.inf

    @property
    def pace(self) -> float:
        """The unit of tau in which the law acts, s / phi(s) up to a factor of 2 where its two powers balance."""
        return 1.0

    @property
    def far_power(self) -> float:
        """From far away s falls as tau^(-1/far_power); 1 where it falls exponentially, at the law's pace."""
        return 1.0

    def longest_step(self, size: float) -> float:
        """The step at which :meth:`advance` of |s| <= ``size`` errs by as much again; infinite where it is exact."""
        return math.inf

    def speed(self, size: float) -> float:
        """phi of one number."""
        return float(self.rate(np.array([size]))[0])


@dataclass(frozen=True)
class LinearFlow(Flow):
    """s' = -s: the nominal and the prescribed-time law in tau."""

    def rate(self, s: Floats) -> Floats:
        return np.asarray(s)

    def advance(self, s: Floats, dtau: float) -> Floats:
        return s * math.exp(-dtau)

    def sketch(self, s: Floats, dtau: float) -> Floats:
        return self.advance(s, dtau)

    def slowest(self, size: Floats, dtau: float) -> Floats:
        return self.advance(size, dtau)

    def fastest(self, size: Floats, dtau: float) -> Floats:
        return self.advance(size, dtau)

    def resolvent(self, c: Floats, dtau: float) -> Floats:
        return c / (1.0 + dtau)

    def time_between(self, start: float, end: float) -> float:
        """tau that |s| takes from ``start`` down to ``end`` > 0."""
        return math.log(start / end)


@dataclass(frozen=True)
class PowerFlow(Flow):
    """s' = -(beta1 |s|^p + beta2 |s|^q) sgn(s), 0 < p < 1 < q: the two fixed-time laws in tau.

    Each half has an exact flow: |s|^(1-p) falls linearly and reaches zero in finite time, |s|^-(q-1) grows
    linearly. They are composed by Strang's rule (half, full, half), second order in dtau, exact at s = 0.
    """

    beta1: float
    beta2: float
    p: Fraction
    q: Fraction

    @cached_property
    def _floats(self) -> tuple[float, float, float, float]:
        return float(self.p), float(self.q), float(1 - self.p), float(self.q - 1)

    @cached_property
    def _roots(self) -> list[tuple[float, int]]:
        """1 / (1 - p) and 1 / (q - 1), each with its number of halves, or 0 if products are not cheaper."""
        roots = 1 / (1 - self.p), 1 / (self.q - 1)
        return [(float(r), r.numerator if r.denominator == 2 and r < 6 else 0) for r in roots]

    @property
    def total_time(self) -> float:
        """pi / ((q - p) sin(pi r)) beta1^(r - 1) beta2^-r with r = (1 - p)/(q - p)."""
        p, q, below, _ = self._floats
        r = below / (q - p)
        return math.pi / ((q - p) * math.sin(math.pi * r)) * self.beta1 ** (r - 1.0) * self.beta2**-r

    @cached_property
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
        """The longest step in tau that Strang's rule allows at a disequilibrium of ``size``.

        In units of pace / (q - p) its error depends on r = (1 - p)/(q - p) only. It vanishes below the balance of both
        powers: if r < 1/2, as s^((q - p)(1 - 2r)/2), and else zero is a few units away.
        """
        p, q, below, _ = self._floats
        width = q - p
        decades = width * (math.log(size) - self._log_balance) if size > 0 else -math.inf
        vanishing = min(0.5, max(0.0, 0.5 - below / width)) * min(decades, 0.0)
        return self.pace / width * math.exp(min(-vanishing, 700.0))

    def rate(self, s: Floats) -> Floats:
        size = np.abs(s)
        p, q, _, _ = self._floats
        with np.errstate(over="ignore"):
            return np.copysign(self.beta1 * size**p + self.beta2 * size**q, s)

    def advance(self, s: Floats, dtau: float) -> Floats:
        return _in_blocks(self._strang, s, dtau)

    def sketch(self, s: Floats, dtau: float) -> Floats:
        return _in_blocks(self._lie, s, dtau)

    def slowest(self, size: Floats, dtau: float) -> Floats:
        """The bound that lets the power below 1 act first, then the power above 1.

        beta1 s^p / (beta2 s^q) falls with s, so the power below 1 acts at the larger s and takes less time off. The
        other order is a lower bound for the same reason.
        """
        return self._brake(self._sink(size.copy(), dtau), dtau)

    def fastest(self, size: Floats, dtau: float) -> Floats:
        return self._sink(self._brake(size.copy(), dtau), dtau)

    def _strang(self, s: Floats, dtau: float) -> Floats:
        size = self._sink(np.abs(s), 0.5 * dtau)
        return np.copysign(self._sink(self._brake(size, dtau), 0.5 * dtau), s)

    def _lie(self, s: Floats, dtau: float) -> Floats:
        return np.copysign(self._sink(self._brake(np.abs(s), dtau), dtau), s)

    def resolvent(self, c: Floats, dtau: float) -> Floats:
        """Newton in v = |s|^p, in which the equation is convex: from above, the iterates fall to the root."""
        p, q, _, _ = self._floats
        moving = c.nonzero()[0]
        goal = np.abs(c[moving])
        v = np.minimum(goal**p, goal / (dtau * self.beta1))
        for _ in range(60):
            value = v ** (1 / p) + dtau * (self.beta1 * v + self.beta2 * v ** (q / p)) - goal
            slope = v ** (1 / p - 1) / p + dtau * (self.beta1 + self.beta2 * q / p * v ** (q / p - 1))
            v, before = np.maximum(v - value / slope, 0.0), v
            if (np.abs(v - before) <= 4e-16 * before).all():
                break
        root = np.zeros_like(c)
        root[moving] = np.copysign(v ** (1 / p), c[moving])
        return root

    def time_between(self, start: float, end: float) -> float:
        """tau that |s| takes from ``start`` down to ``end`` >= 0.

        With v = (q - p) ln(s / c), c where both powers are equal, tau is pace / (q - p) times the integral of
        e^(r v) / (1 + e^v), r = (1 - p)/(q - p). Below -40 and above 40 one power is all to the last bit; between,
        ten Gauss points in each panel of width 2 leave an error below 1e-12, however far the exponents are from 1.
        """
        p, q, below, above = self._floats
        width = q - p
        low, high = (width * (math.log(s) - self._log_balance) if s > 0 else -math.inf for s in (end, start))
        sink = _exponential_integral(below / width, min(low, -_FLAT), min(high, -_FLAT))
        brake = _exponential_integral(-above / width, max(low, _FLAT), max(high, _FLAT))
        low, high = max(low, -_FLAT), min(high, _FLAT)
        both = _panels(below / width, low, high) if low < high else 0.0
        return self.pace / width * (sink + both + brake)

    def _sink(self, size: Floats, dtau: float) -> Floats:
        """s' = -beta1 s^p, in place."""
        _, _, below, _ = self._floats
        fall = below * self.beta1 * dtau
        if below < _NEAR_ONE:
            with np.errstate(divide="ignore", invalid="ignore"):
                share = np.minimum(fall * size**-below, 1.0)
                size *= np.exp(np.log1p(-share) / below)
            return size
        np.power(size, below, out=size)
        size -= fall
        np.maximum(size, 0.0, out=size)
        return fractional_power(size, *self._roots[0])

    def _brake(self, size: Floats, dtau: float) -> Floats:
        """s' = -beta2 s^q, in place, written so that s = 0 stays 0."""
        _, _, _, above = self._floats
        fall = above * self.beta2 * dtau
        with np.errstate(over="ignore"):
            growth = size**above
            growth *= fall
        if above < _NEAR_ONE:
            size *= np.exp(np.log1p(growth) / -above)
            return size
        far = growth > _HUGE
        growth += 1.0
        size /= fractional_power(growth, *self._roots[1])
        if far.any():
            size[far] = fall ** (-1.0 / above)
        return size


_NEAR_ONE = 1e-3
"""Distance of an exponent from 1 below which a root of that order would lose more than three digits."""

_HUGE = 1e200
"""Where the power above 1 of a state nears the largest double; its start is forgotten there to the last bit."""

_FLAT = 40.0


def _exponential_integral(rate: float, low: float, high: float) -> float:
    """The integral of e^(rate v); ``low`` may be -inf at a positive rate, ``high`` +inf at a negative one."""
    return 0.0 if low == high else (math.exp(rate * high) - math.exp(rate * low)) / rate


def _panels(rate: float, low: float, high: float) -> float:
    """The integral of e^(rate v) / (1 + e^v) between -40 and 40."""
    edges = np.linspace(low, high, math.ceil(0.5 * (high - low)) + 1)
    points, weights = _gauss()
    half = 0.5 * np.diff(edges)
    v = 0.5 * (edges[1:] + edges[:-1])[:, None] + half[:, None] * points
    return float(half @ (np.exp(rate * v) / (1.0 + np.exp(v)) @ weights))


BLOCK = 16_384
"""Numbers that a chain of array operations handles at once: they stay in the cache, twice as fast at 1e5."""


def _in_blocks(function: Callable[[Floats, float], Floats], s: Floats, dtau: float) -> Floats:
    if s.size <= BLOCK:
        return function(s, dtau)
    return np.concatenate([function(s[k : k + BLOCK], dtau) for k in range(0, s.size, BLOCK)])


def fractional_power(base: Floats, exponent: float, halves: int) -> Floats:
    """base^exponent; where the exponent is halves / 2, halves odd, by one root and products.

    1 / (1 - p) is half an odd number for the paper's exponents, and a root costs a fifth of a power.
    """
    if not halves:
        return base**exponent
    result = np.sqrt(base)
    for _ in range(halves // 2):
        result *= base
    return result


@cache
def _gauss() -> tuple[Floats, Floats]:
    return np.polynomial.legendre.leggauss(10)
