"""Polynomials q(s) = sum_k c_k s^k on [0, 1]: values, derivatives, restrictions, Bernstein bounds.

Coefficients are arrays (n, degree + 1, dof) of n polynomials, ascending powers of s along axis 1.
"""

from functools import cache
from math import comb

import numpy as np

from planner.base.arrays import Floats, frozen


def evaluate(coefficients: Floats, s: Floats) -> Floats:
    """Return the values (n, dof) of n polynomials, each at its own s (n,)."""
    value = coefficients[:, -1]
    for k in range(coefficients.shape[1] - 2, -1, -1):
        value = value * s[:, None] + coefficients[:, k]
    return value


def derivative(coefficients: Floats, order: int = 1) -> Floats:
    """Return the coefficients of the derivative by s; zero for a constant."""
    for _ in range(order):
        powers = np.arange(1, coefficients.shape[1])
        coefficients = coefficients[:, 1:] * powers[:, None] if len(powers) else np.zeros_like(coefficients)
    return coefficients


def part(coefficients: Floats, low: Floats, high: Floats) -> Floats:
    """Return q(low + u (high - low)) as polynomials of u in [0, 1], ``low`` and ``high`` (n,)."""
    shifted = coefficients.copy()
    degree = coefficients.shape[1] - 1
    for k in range(degree):  # repeated Horner scheme: the Taylor expansion at low
        for j in range(degree - 1, k - 1, -1):
            shifted[:, j] += low[:, None] * shifted[:, j + 1]
    return shifted * powers(high - low, degree)[:, :, None]


def powers(x: Floats, most: int) -> Floats:
    """Return the powers (n, most + 1) of x (n,), by products, as ``**`` varies by processor."""
    return np.multiply.accumulate(np.column_stack([np.ones_like(x), *[x] * most]), axis=1)


def bernstein(coefficients: Floats) -> Floats:
    """Return Bernstein coefficients (n, degree + 1, dof), whose range bounds the polynomial."""
    return np.einsum("jk,nkd->njd", _to_bernstein(coefficients.shape[1] - 1), coefficients)


@cache
def _to_bernstein(degree: int) -> Floats:
    """(degree + 1, degree + 1): row j gives the j-th Bernstein coefficient by the powers' coefficients."""
    return frozen([[comb(j, k) / comb(degree, k) for k in range(degree + 1)] for j in range(degree + 1)])
