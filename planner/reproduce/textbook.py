"""Remark (implementation): the methods that the paper names, in the paper's own time t, right up to T_p."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner import gabf
from planner.base.arrays import Floats
from planner.gabf.problem import Problem, reduce
from planner.gabf.references import implicit_step


@dataclass(frozen=True, eq=False)
class SolverRun:
    """A run as one method made it: ``error`` max_i |x_i - x_i*| (k,) after the steps that ended at ``t`` (k,).

    ``reached``: the method came to the end of the interval; ``message``: what it said, or "".
    """

    method: str
    t: Floats
    error: Floats
    evaluations: int
    reached: bool = True
    message: str = ""

    @property
    def best(self) -> float:
        """The smallest error of all steps."""
        return float(self.error.min())

    @property
    def last(self) -> float:
        return float(self.error[-1])

    def until(self, t: float) -> float:
        """The error at the last step that ended by ``t``."""
        return float(self.error[np.searchsorted(self.t, t, side="right") - 1])


@dataclass(frozen=True, eq=False)
class Initial:
    """dx/dt = -etabar(t) phi(xhat), eqs. (prespecified) and (fully), from ``x0`` towards ``x_star`` (n,).

    The same as :func:`planner.gabf.right_side`, but on packed states and with the gain by its formula in t: that one
    takes it at the clock's tau, by Newton's method, which would be most of what an explicit solver spends.
    """

    network: gabf.Network
    law: gabf.PrescribedTime | gabf.SingularityFree
    x0: float | Floats
    x_star: Floats

    @cached_property
    def problem(self) -> Problem:
        return reduce(self.network)

    @cached_property
    def y0(self) -> Floats:
        return self.problem.pack(np.broadcast_to(np.asarray(self.x0, dtype=np.float64), self.network.n_nodes))

    def gain(self, t: float) -> float:
        """etabar(t) of eq. (ebar)."""
        law = self.law
        return law.gamma + 2.0 * (1.0 + law.h) / (law.T - t) if t < law.T else 0.0

    def slope(self, t: float, y: Floats) -> Floats:
        """dy/dt of the packed states."""
        u = -self.gain(t) * self.law.flow.rate(self.problem.disequilibrium(y))
        return np.concatenate((u, np.zeros(self.problem.anchors.size)))

    def error(self, y: Floats) -> float:
        """max_i |y_i - x_i*|; +inf where a state has overflowed."""
        rows = self.problem.n_rows
        worst = float(np.abs(y[:rows] - self.x_star[self.problem.rows]).max())
        return np.inf if np.isnan(worst) else worst


def forward_euler(initial: Initial, steps: int) -> SolverRun:
    """x(t + dt) = x(t) + dt u(t), dt = T_p / ``steps``, up to T_p.

    k steps before T_p its step is 2 (1 + h) / k in tau, however small dt is: there it leaves the stable range.
    """
    dt, y, errors = initial.law.T / steps, initial.y0, []
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(steps):
            y = y + dt * initial.slope(k * dt, y)
            errors.append(initial.error(y))
    return SolverRun("forward Euler", dt * np.arange(1.0, steps + 1), np.array(errors), steps)


def backward_euler(initial: Initial, steps: int) -> SolverRun:
    """x(t + dt) = x(t) + dt u(t + dt), dt = T_p / ``steps``; the last step, at T_p, has no gain, eq. (ebar).

    Each step is one of :class:`planner.gabf.BackwardEuler`, of a length in tau that grows as T_p comes near.
    """
    dt, y, count, errors = initial.law.T / steps, initial.y0, 0, []
    for k in range(1, steps):
        y, sweeps = implicit_step(initial.problem, initial.law.flow, y, dt * initial.gain(k * dt))
        errors.append(initial.error(y))
        count += sweeps
    errors.append(initial.error(y))
    return SolverRun("backward Euler", dt * np.arange(1.0, steps + 1), np.array(errors), count)


def runge_kutta(initial: Initial, end: float, rtol: float = 1e-6) -> SolverRun:
    """SciPy's RK45, the pair that MATLAB's ode45 uses, from 0 to ``end`` in t."""
    from scipy.integrate import solve_ivp

    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        run = solve_ivp(initial.slope, (0.0, end), initial.y0, method="RK45", rtol=rtol)
    errors = np.array([initial.error(y) for y in run.y.T])
    return SolverRun("RK45", run.t, errors, run.nfev, run.status == 0, "" if run.status == 0 else run.message)
