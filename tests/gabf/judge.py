"""An integrator that shares nothing with the package's solvers, to judge when a law settles.

SciPy's implicit Radau method at tight tolerance, on the law itself: phi is only rounded off within ``ROUNDED`` of 0,
where its slope is infinite; that is far inside the band of every test here.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import Radau

from planner import gabf

ROUNDED = 1e-8


def settling_tau(net, law, x0, tolerance=1e-6, rtol=1e-7, max_steps=20_000):
    """The last tau at which an error leaves its band, or None if Radau does not get there in ``max_steps``."""
    x_star = gabf.oracle(net)
    rows = np.setdiff1d(np.arange(net.n_nodes), net.sources)
    band = tolerance * np.maximum(1.0, np.abs(x_star[rows]))
    speed, slope = _law(law)

    def disequilibrium(y):
        x = x_star.copy()
        x[rows] = y
        values = net.arcs(x[net.indices])
        arc = [int(a + np.argmin(values[a:b])) for a, b in zip(net.indptr[rows], net.indptr[rows + 1], strict=True)]
        return y - values[arc], arc

    def jacobian(_, y):
        s, arc = disequilibrium(y)
        step = 1e-6
        gain = (net.arcs(x_star[net.indices] + step) - net.arcs(x_star[net.indices])) / step
        matrix = np.eye(rows.size)
        place = {int(node): k for k, node in enumerate(rows)}
        for i, a in enumerate(arc):
            if (j := place.get(int(net.indices[a]))) is not None:
                matrix[i, j] -= gain[a]
        return -slope(s)[:, None] * matrix

    solver = Radau(
        lambda _, y: -speed(disequilibrium(y)[0]), 0.0, x0[rows], np.inf, rtol=rtol, atol=2e-3 * tolerance, jac=jacobian
    )
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
    p, q, b1, b2 = law.p[0] / law.p[1], law.m[0] / law.m[1], law.beta1, law.beta2

    def size(s):
        return np.sqrt(s * s + ROUNDED**2)

    def speed(s):
        return s * (b1 * size(s) ** (p - 1) + b2 * np.abs(s) ** (q - 1))

    def slope(s):
        round_off = (ROUNDED / size(s)) ** 2
        return b1 * size(s) ** (p - 1) * (p + (1 - p) * round_off) + b2 * q * np.abs(s) ** (q - 1)

    return speed, slope
