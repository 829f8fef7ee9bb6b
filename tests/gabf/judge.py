"""An integrator that shares nothing with the package's solver, to judge where a law's states are and when they settle.

SciPy's implicit Radau method at tight tolerance, on the law itself: phi is only rounded off within ``ROUNDED`` of 0,
where its slope is infinite; that is far inside the band of every test here.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import Radau, solve_ivp

from planner import gabf

ROUNDED = 1e-8


def states(net, law, x0, taus, rtol=1e-8):
    """(k, n) the states at ascending readings of the clock; x* where no source is reached."""
    x_star, rows, right_side, jacobian = _equation(net, law)
    x = np.broadcast_to(np.asarray(x0, dtype=float), net.n_nodes)[rows]
    end = max(float(taus[-1]), 1e-12)
    found = solve_ivp(right_side, (0.0, end), x, "Radau", np.minimum(taus, end), rtol=rtol, atol=1e-9, jac=jacobian)
    every = np.tile(x_star, (len(taus), 1))
    every[:, rows] = found.y.T
    return every


def settling_tau(net, law, x0, tolerance=1e-6, rtol=1e-7, max_steps=20_000):
    """The last tau at which an error leaves its band, or None if Radau does not get there in ``max_steps``."""
    x_star, rows, right_side, jacobian = _equation(net, law)
    band = tolerance * np.maximum(1.0, np.abs(x_star[rows]))
    solver = Radau(right_side, 0.0, x0[rows], np.inf, rtol=rtol, atol=2e-3 * tolerance, jac=jacobian)
    last = 0.0
    for _ in range(max_steps):
        solver.step()
        if solver.status != "running":
            return None
        excess = np.abs(solver.y - x_star[rows]) - band
        if excess.max() > 0:
            last = None
        elif last is None:
            last = _crossing(solver, x_star[rows], band)
        if (excess < -0.9 * band).all():
            return last
    return None


def _equation(net, law):
    """x*, the nodes that move, and the right side of their equation in tau with its Jacobian."""
    x_star = gabf.oracle(net)
    rows = np.setdiff1d(np.flatnonzero(np.isfinite(x_star)), net.sources)
    speed, slope = _law(law)

    def disequilibrium(y):
        x = x_star.copy()
        x[rows] = y
        values = np.where(np.isfinite(x_star[net.indices]), net.arcs(np.nan_to_num(x[net.indices])), np.inf)
        arc = [int(a + np.argmin(values[a:b])) for a, b in zip(net.indptr[rows], net.indptr[rows + 1], strict=True)]
        return y - values[arc], arc

    def jacobian(_, y):
        s, arc = disequilibrium(y)
        step, here = 1e-6, np.nan_to_num(x_star[net.indices])
        gain = (net.arcs(here + step) - net.arcs(here)) / step
        matrix = np.eye(rows.size)
        place = {int(node): k for k, node in enumerate(rows)}
        for i, a in enumerate(arc):
            if (j := place.get(int(net.indices[a]))) is not None:
                matrix[i, j] -= gain[a]
        return -slope(s)[:, None] * matrix

    return x_star, rows, lambda _, y: -speed(disequilibrium(y)[0]), jacobian


def _crossing(solver, x_star, band):
    low, high, at = solver.t_old, solver.t, solver.dense_output()
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (np.abs(at(middle) - x_star) > band).any() else (low, middle)
    return high


def _law(law):
    """phi and its derivative, from the law's own parameters."""
    if isinstance(law, gabf.Nominal | gabf.PrescribedTime):
        return lambda s: s, np.ones_like
    if isinstance(law, gabf.UserLaw):
        return law.rate, lambda s: (law.rate(s + ROUNDED) - law.rate(s - ROUNDED)) / (2 * ROUNDED)
    p, q, b1, b2 = law.p[0] / law.p[1], law.m[0] / law.m[1], law.beta1, law.beta2

    def size(s):
        return np.sqrt(s * s + ROUNDED**2)

    def speed(s):
        return s * (b1 * size(s) ** (p - 1) + b2 * np.abs(s) ** (q - 1))

    def slope(s):
        round_off = (ROUNDED / size(s)) ** 2
        return b1 * size(s) ** (p - 1) * (p + (1 - p) * round_off) + b2 * q * np.abs(s) ** (q - 1)

    return speed, slope
