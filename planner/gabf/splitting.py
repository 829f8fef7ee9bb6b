"""The structure-preserving solver: exact scalar flows around parent values that a half step has moved."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal, Protocol

import numpy as np

from planner.arrays import Floats
from planner.errors import OptionError
from planner.gabf.flows import Flow
from planner.gabf.problem import Problem
from planner.gabf.solvers import Solver, State, Targets, disequilibrium, mean_cost

COMPILE_FROM = 30_000
"""Rows from which Numba repays its import (0.65 s) and a first compilation."""


@dataclass(frozen=True)
class Splitting(Solver):
    """Hold each parent value m_i = min_j f_i(y_j, w_ij), and y_i - m_i follows a scalar equation of exact flow.

    A step takes m from a half step (midpoint rule, order 2) and flows across the whole. It has no stability
    limit, no chatter at y_i = m_i, and ends on the fixed point to the last bit: large steps become
    Bellman-Ford sweeps. ``tolerance`` is the error in tau that one step may make, estimated from how far m moved:
    a smaller one takes more steps and places the settling time better (at 0.05 it is about 5 % late, at 0.005
    below 1 %); the final x is the same. ``max_step`` bounds a step in tau; with an infinite tolerance every step
    has that size. ``backend`` "auto" compiles from 30 000 nodes on, if Numba is there.

        solve(net, solver=Splitting(tolerance=1e-3))
    """

    tolerance: float = 0.05
    max_step: float = np.inf
    backend: Literal["auto", "numpy", "numba"] = "auto"
    order: ClassVar[int] = 2
    exact_rest: ClassVar[bool] = True
    name: ClassVar[str] = "splitting"

    def __post_init__(self) -> None:
        if not (self.tolerance > 0 and self.max_step > 0):
            raise OptionError("tolerance and max_step of the splitting solver must be positive")
        if np.isinf(self.tolerance) and np.isinf(self.max_step):
            raise OptionError("an infinite tolerance needs a finite max_step, the size of every step")
        if self.backend not in ("auto", "numpy", "numba"):
            raise OptionError(f"backend must be auto, numpy or numba, not {self.backend!r}")

    def states(self, problem: Problem, flow: Flow, y0: Floats, targets: Floats) -> Iterator[State]:
        """See :class:`planner.gabf.solvers.Solver`."""
        stepper, landing = self._stepper(problem, flow), Targets(targets)
        tau, y, xhat, count = 0.0, y0, stepper.disequilibrium(y0), 1
        hop = mean_cost(problem, y0)
        dtau = self._first_step(flow, xhat, hop)
        while True:
            yield State(tau, y, xhat, count)
            size = min(float(np.abs(xhat).max(initial=0.0)), hop)
            allowed = self.tolerance * flow.speed(size) / size if size else np.inf
            while True:
                step, reached = landing.clip(tau, dtau)
                y_next, share = stepper.step(y, xhat, step, size)
                count += 1
                if share <= allowed:
                    break
                dtau = step * max(0.2, 0.9 * allowed / share)
            tau, y = reached, y_next
            xhat, count = stepper.disequilibrium(y), count + 1
            growth = 0.9 * allowed / share if share > 0.45 * allowed else 2.0
            dtau = min(max(dtau, step) * growth, self.max_step)

    def _stepper(self, problem: Problem, flow: Flow) -> Stepper:
        large = problem.n_rows >= COMPILE_FROM
        if self.backend == "numpy" or (self.backend == "auto" and not large):
            return NumpyStepper(problem, flow)
        from planner.gabf import compiled  # 0.65 s, so only where it pays

        if compiled.available(problem):
            return compiled.compiled_stepper(problem, flow)
        if self.backend == "numba":
            raise OptionError("backend numba needs Numba installed and a built-in kernel: use backend auto")
        return NumpyStepper(problem, flow)

    def _first_step(self, flow: Flow, xhat: Floats, hop: float) -> float:
        if np.isinf(self.tolerance):
            return self.max_step
        size = max(min(float(np.abs(xhat).max(initial=0.0)), hop), np.finfo(float).tiny)
        return min(size / flow.speed(size), self.max_step)


class Stepper(Protocol):
    """One step of the splitting method."""

    def disequilibrium(self, y: Floats) -> Floats:
        """xhat (R,), eq. (xhat)."""
        ...

    def step(self, y: Floats, xhat: Floats, dtau: float, size: float) -> tuple[Floats, float]:
        """y after ``dtau``, and how far off the step may be, as a share of ``size`` + |xhat_i|.

        Had m not been moved by delta, the step would have ended delta (1 - rho) elsewhere, rho the share of
        y_i - m_i that the flow leaves over. The law undoes an error of ``size`` in size / phi(size), so this
        share counts as a time: ``size`` is the largest disequilibrium, or an average arc cost if smaller.
        """
        ...


@dataclass(frozen=True, eq=False)
class NumpyStepper:
    """The step on arrays; nodes that rest on their parent value cost no power."""

    problem: Problem
    flow: Flow

    def disequilibrium(self, y: Floats) -> Floats:
        return disequilibrium(self.problem, y)

    def step(self, y: Floats, xhat: Floats, dtau: float, size: float) -> tuple[Floats, float]:
        rows = xhat.size
        m = y[:rows] - xhat
        m_mid = self.problem.parent_values(self._flow_towards(y, m, xhat, 0.5 * dtau)[0])
        s_mid = y[:rows] - m_mid
        y_next, left = self._flow_towards(y, m_mid, s_mid, dtau)
        hit = ((m_mid != m) & (s_mid != 0)).nonzero()[0]
        if hit.size == 0:
            return y_next, 0.0
        gone = 1.0 - left[hit] / s_mid[hit]
        share = np.abs(m_mid[hit] - m[hit]) * gone / (size + np.abs(xhat[hit]))
        return y_next, float(share.max())

    def _flow_towards(self, y: Floats, m: Floats, s: Floats, dtau: float) -> tuple[Floats, Floats]:
        moving = s.nonzero()[0]
        left = np.zeros_like(s)
        left[moving] = self.flow.advance(s[moving], dtau)
        y_next = y.copy()
        np.add(m, left, out=y_next[: m.size])
        return y_next, left
