"""Exact flows of the scalar equations that the laws become while a node's parent value is held fixed."""

from __future__ import annotations

import itertools
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
    def sketch(self, s: Floats, dtau: float) -> Floats:
        """The same to first order in ``dtau``, for less work; exact at s = 0."""

    @abstractmethod
    def resolvent(self, c: Floats, dtau: float) -> Floats:
        """The root s of s + dtau phi(s) = c: one backward Euler step."""

    @property
    def total_time(self) -> float:
        """tau from infinity down to 0; infinite for a linear flow."""
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

    def rate(self, s: Floats) -> Floats:
        size = np.abs(s)
        p, q, _, _ = self._floats
        return np.copysign(self.beta1 * size**p + self.beta2 * size**q, s)

    def advance(self, s: Floats, dtau: float) -> Floats:
        return _in_blocks(self._strang, s, dtau)

    def sketch(self, s: Floats, dtau: float) -> Floats:
        return _in_blocks(self._lie, s, dtau)

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

        With z = s^(1-p) the integrand 1 / ((1-p) (beta1 + beta2 z^r)), r = (q-p)/(1-p) > 1, is smooth down to
        zero; panels double towards large z, so that ten Gauss points in each leave an error below 1e-9.
        """
        one_p = float(1 - self.p)
        low, high = end**one_p, start**one_p
        edges = [low]
        while edges[-1] < high:
            edges.append(min(high, max(2.0 * edges[-1], edges[-1] + 0.25)))
        return sum(self._panel(a, b) for a, b in itertools.pairwise(edges))

    def _panel(self, a: float, b: float) -> float:
        points, weights = _gauss()
        z = 0.5 * (a + b) + 0.5 * (b - a) * points
        r = float((self.q - self.p) / (1 - self.p))
        inverse_speed = 1.0 / (float(1 - self.p) * (self.beta1 + self.beta2 * z**r))
        return float(0.5 * (b - a) * (weights @ inverse_speed))

    def _sink(self, size: Floats, dtau: float) -> Floats:
        """s' = -beta1 s^p, in place."""
        _, _, below, _ = self._floats
        np.power(size, below, out=size)
        size -= below * self.beta1 * dtau
        np.maximum(size, 0.0, out=size)
        return fractional_power(size, *self._roots[0])

    def _brake(self, size: Floats, dtau: float) -> Floats:
        """s' = -beta2 s^q, in place, written so that s = 0 stays 0."""
        _, _, _, above = self._floats
        growth = size**above
        growth *= above * self.beta2 * dtau
        growth += 1.0
        size /= fractional_power(growth, *self._roots[1])
        return size


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
