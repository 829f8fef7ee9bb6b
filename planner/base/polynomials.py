"""Polynomial pieces q(s) = sum_k c_k s^k on [0, 1]: values, derivatives, parts, Bernstein bounds, exact extrema.

Coefficients are arrays (n, degree + 1, dof), ascending powers of s along axis 1; n pieces are worked on at once.
"""

from __future__ import annotations

from functools import cache
from math import comb

import numpy as np

from planner.base.arrays import Floats, frozen

_HALVINGS = 60  # of an interval on which a polynomial is monotone: its root to the last bit of s


def evaluate(coefficients: Floats, s: Floats) -> Floats:
    """Values (n, dof) of n pieces, each at its own s (n,)."""
    value = coefficients[:, -1]
    for k in range(coefficients.shape[1] - 2, -1, -1):
        value = value * s[:, None] + coefficients[:, k]
    return value


def derivative(coefficients: Floats, order: int = 1) -> Floats:
    """Coefficients of the derivative by s; of a constant those of zero."""
    for _ in range(order):
        powers = np.arange(1, coefficients.shape[1])
        coefficients = coefficients[:, 1:] * powers[:, None] if len(powers) else np.zeros_like(coefficients)
    return coefficients


def part(coefficients: Floats, low: Floats, high: Floats) -> Floats:
    """Each piece on its own [low, high], (n,) each, as a piece on [0, 1]: q(low + u (high - low))."""
    shifted = coefficients.copy()
    degree = coefficients.shape[1] - 1
    for k in range(degree):  # Horner's scheme, once a power: the Taylor expansion at low
        for j in range(degree - 1, k - 1, -1):
            shifted[:, j] += low[:, None] * shifted[:, j + 1]
    return shifted * ((high - low)[:, None] ** np.arange(degree + 1))[:, :, None]


def bernstein(coefficients: Floats) -> Floats:
    """The Bernstein coefficients (n, degree + 1, dof); a piece stays between their least and their largest."""
    return np.einsum("jk,nkd->njd", _to_bernstein(coefficients.shape[1] - 1), coefficients)


def extrema(coefficients: Floats) -> tuple[Floats, Floats]:
    """The least and the largest value (n, dof) of every piece on [0, 1], exact but for rounding."""
    places = np.concatenate(
        [np.zeros_like(coefficients[:, :1]), _roots(derivative(coefficients)), np.ones_like(coefficients[:, :1])],
        axis=1,
    )
    values = _values(coefficients, places)
    return values.min(axis=1), values.max(axis=1)


@cache
def _to_bernstein(degree: int) -> Floats:
    """(degree + 1, degree + 1): row j gives the j-th Bernstein coefficient by the powers' coefficients."""
    return frozen([[comb(j, k) / comb(degree, k) for k in range(degree + 1)] for j in range(degree + 1)])


def _values(coefficients: Floats, places: Floats) -> Floats:
    """Values (n, m, dof) at ``places`` (n, m, dof), every joint at its own."""
    value = coefficients[:, -1:]
    for k in range(coefficients.shape[1] - 2, -1, -1):
        value = value * places + coefficients[:, k : k + 1]
    return value if value.shape == places.shape else np.broadcast_to(value, places.shape)


def _roots(coefficients: Floats) -> Floats:
    """Places (n, degree, dof) in [0, 1] that hold every change of sign of a piece.

    Between two neighbouring roots of its derivative a polynomial is monotone, so halving finds the one root there;
    where it has none the place is of no harm.
    """
    n, count, dof = coefficients.shape
    if count == 1:
        return np.zeros((n, 0, dof))
    if count == 2:
        with np.errstate(divide="ignore", invalid="ignore"):
            root = -coefficients[:, :1] / coefficients[:, 1:]
        return np.clip(np.nan_to_num(root, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    turns = np.sort(_roots(derivative(coefficients)), axis=1)
    ends = np.concatenate([np.zeros((n, 1, dof)), turns, np.ones((n, 1, dof))], axis=1)
    low, high = ends[:, :-1], ends[:, 1:]
    rises = _values(coefficients, low) < 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        before = (_values(coefficients, middle) < 0.0) == rises
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return 0.5 * (low + high)
