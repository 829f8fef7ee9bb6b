"""Pieces against NumPy's own polynomials and dense sampling; bounds hold and extrema are attained."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from planner.base.polynomials import bernstein, derivative, evaluate, part
from planner.native.compiled import polynomial_extrema as extrema

DEGREES = range(6)


def pieces(degree: int, seed: int = 0, n: int = 40, dof: int = 3) -> np.ndarray:
    """Random pieces, some of a lower degree than they have coefficients."""
    rng = np.random.default_rng(seed + degree)
    coefficients = rng.normal(size=(n, degree + 1, dof)) * rng.choice([0.0, 1e-9, 1.0, 30.0], size=(n, degree + 1, dof))
    return coefficients


def sampled(coefficients: np.ndarray, count: int = 2001) -> np.ndarray:
    """(count, n, dof) by NumPy's own polynomials."""
    s = np.linspace(0.0, 1.0, count)
    n, _, dof = coefficients.shape
    rows = [[Polynomial(coefficients[i, :, j])(s) for j in range(dof)] for i in range(n)]
    return np.moveaxis(np.array(rows), 2, 0)


@pytest.mark.parametrize("degree", DEGREES)
def test_values_derivatives_and_parts(degree: int) -> None:
    c, rng = pieces(degree), np.random.default_rng(degree)
    s, low = rng.uniform(size=len(c)), rng.uniform(0, 0.5, size=len(c))
    high = low + rng.uniform(0, 0.5, size=len(c))
    scale = np.abs(c).sum(axis=1) + 1.0
    for order in range(3):
        slope = derivative(c, order)
        want = [[Polynomial(c[i, :, j]).deriv(order)(s[i]) for j in range(3)] for i in range(len(c))]
        assert (np.abs(evaluate(slope, s) - want) < 1e-13 * 40 * scale).all()
    inside = evaluate(c, low + s * (high - low))
    assert (np.abs(evaluate(part(c, low, high), s) - inside) < 1e-13 * scale).all()


@pytest.mark.parametrize("degree", DEGREES)
def test_bounds_hold_and_extrema_are_attained(degree: int) -> None:
    c = pieces(degree, 7)
    values, (low, high) = sampled(c), extrema(c)
    hull, scale = bernstein(c), np.abs(c).sum(axis=1) + 1.0
    assert (hull.min(axis=1) <= low + 1e-12 * scale).all()
    assert (hull.max(axis=1) >= high - 1e-12 * scale).all()
    steepest = np.abs(derivative(c)).sum(axis=1) + np.abs(derivative(c, 2)).sum(axis=1)
    assert (values.min(axis=0) >= low - 1e-12 * scale).all()
    assert (values.max(axis=0) <= high + 1e-12 * scale).all()
    assert (values.min(axis=0) <= low + 5e-4 * steepest + 1e-12).all()
    assert (values.max(axis=0) >= high - 5e-4 * steepest - 1e-12).all()


def test_extrema_of_a_known_quintic() -> None:
    """Chebyshev's T5 of 2 s - 1 touches -1 and 1 five times on [0, 1]."""
    t5 = np.polynomial.Chebyshev.basis(5, domain=[0, 1]).convert(kind=Polynomial, domain=[-1, 1], window=[-1, 1])
    low, high = extrema(np.array(t5.coef, dtype=float).reshape(1, 6, 1))
    np.testing.assert_allclose([low[0, 0], high[0, 0]], [-1.0, 1.0], atol=1e-12)
