"""Exact flows of the scalar equations that the laws become while a node's parent value is held fixed."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from planner.arrays import Floats


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
    def resolvent(self, c: Floats, dtau: float) -> Floats:
        """The root s of s + dtau phi(s) = c: one backward Euler step."""

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

    def resolvent(self, c: Floats, dtau: float) -> Floats:
        return c / (1.0 + dtau)

    def time_between(self, start: float, end: float) -> float:
        """tau that |s| takes from ``start`` down to ``end`` > 0."""
        return math.log(start / end)


@dataclass(frozen=True)
class PowerFlow(Flow):
    """s' = -(beta1 |s|^p + beta2 |s|^q) sgn(s), 0 < p < 1 < q: the fixed-time and the singularity-free law in
    tau.

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
    def roots(self) -> tuple[Fraction, Fraction]:
        """1 / (1 - p) and 1 / (q - 1)."""
        return 1 / (1 - self.p), 1 / (self.q - 1)

    def rate(self, s: Floats) -> Floats:
        size = np.abs(s)
        p, q, _, _ = self._floats
        return np.copysign(self.beta1 * size**p + self.beta2 * size**q, s)

    def advance(self, s: Floats, dtau: float) -> Floats:
        size = self._sink(np.abs(s), 0.5 * dtau)
        size = self._sink(self._brake(size, dtau), 0.5 * dtau)
        return np.copysign(size, s)

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
        zero; panels double towards large z, so that ten Gauss points in each leave an error below 1e-9."""
        one_p = float(1 - self.p)
        low, high = end**one_p, start**one_p
        edges = [low]
        while edges[-1] < high:
            edges.append(min(high, max(2.0 * edges[-1], edges[-1] + 0.25)))
        return sum(self._panel(a, b) for a, b in itertools.pairwise(edges))

    def _panel(self, a: float, b: float) -> float:
        z = 0.5 * (a + b) + 0.5 * (b - a) * GAUSS_POINTS
        r = float((self.q - self.p) / (1 - self.p))
        inverse_speed = 1.0 / (float(1 - self.p) * (self.beta1 + self.beta2 * z**r))
        return float(0.5 * (b - a) * (GAUSS_WEIGHTS @ inverse_speed))

    def _sink(self, size: Floats, dtau: float) -> Floats:
        """s' = -beta1 s^p."""
        _, _, below, _ = self._floats
        rest = size**below - below * self.beta1 * dtau
        return fractional_power(np.maximum(rest, 0.0), self.roots[0])

    def _brake(self, size: Floats, dtau: float) -> Floats:
        """s' = -beta2 s^q, written so that s = 0 stays 0."""
        _, _, _, above = self._floats
        growth = 1.0 + above * self.beta2 * dtau * size**above
        return size / fractional_power(growth, self.roots[1])


def fractional_power(base: Floats, exponent: Fraction) -> Floats:
    """base^exponent; half-integers up to 11/2, which the paper's exponents lead to, by products and one root.

    A square root and products cost a fifth of a power.
    """
    if exponent.denominator != 2 or exponent > 6:
        return base ** float(exponent)
    result = np.sqrt(base)
    for _ in range(exponent.numerator // 2):
        result *= base
    return result


GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(10)
