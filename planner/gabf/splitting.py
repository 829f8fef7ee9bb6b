"""The structure-preserving solver: exact scalar flows around parent values that a half step has moved."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.gabf.flows import Flow
from planner.gabf.kernels import AffineArcs
from planner.gabf.problem import Problem, Standing
from planner.native.compiled import NativeArcs, NativeFlow

_EPS, _TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)
_ROUNDED = 64 * _EPS
"""Share of the largest state below which a disequilibrium may be rounding: steps are not measured by less."""
_SAFETY = 0.9
_FINEST = 1e-12
"""What no double resolves: of the states, the disequilibrium that steps are measured by; of the time in which the law
undoes the largest one, a step. Without it, steps shrink for ever where states are 1e13 times an arc's cost.
"""


@dataclass(frozen=True)
class Splitting:
    """Hold each parent value m_i = min_j f_i(y_j, w_ij): then y_i - m_i follows a scalar equation of known flow.

    A step takes m from about half a step (order 2) and flows across the whole. It has no stability limit, no
    chatter at y_i = m_i, and ends on the fixed point to the last bit: large steps become Bellman-Ford
    sweeps. ``tolerance`` is the error in tau that one step may make, in units of the law's own pace and
    estimated from how far m moved: a smaller one takes more steps and places the settling time better (at
    0.05 mostly within 3 %, at 0.005 within 0.5 %); the final x is the same. What is proved of the settling
    time is :attr:`planner.gabf.CostToGo.settling_tau_bracket`. ``max_step`` bounds a step in tau; with an
    infinite tolerance every step has that size. A parent that takes over in the second half of a step has not moved m
    before, so no tolerance sees it: where saved states have to be right to some digits, give a ``max_step`` too.

    >>> network = gabf.Network.from_arcs([1], [0], [1.0], sources=[0], n_nodes=2)
    >>> round(gabf.solve(network, "nominal", x0=2.0, solver=gabf.Splitting(1e-3)).settling_tau, 2)  # ln 1e9
    20.72
    """

    tolerance: float = 0.05
    max_step: float = np.inf

    def __post_init__(self) -> None:
        if not (self.tolerance > 0 and self.max_step > 0):
            raise OptionError("tolerance and max_step of the splitting solver must be positive")
        if np.isinf(self.tolerance) and np.isinf(self.max_step):
            raise OptionError("an infinite tolerance needs a finite max_step, the size of every step")

    def allowed(self, flow: Flow, size: float) -> float:
        """The share of a disequilibrium of ``size`` that a step may err by.

        It is ``tolerance`` in tau, in units of the law's own pace, and at most a share of the time in which the law
        undoes the disequilibrium.
        """
        return self.tolerance * flow.urgency(size) if size else np.inf

    def longest_step(self, flow: Flow, size: float) -> float:
        """Strang's rule itself errs by about (dtau / longest)^3 longest in tau. At last, nothing is left to be done."""
        if np.isinf(self.tolerance):
            return self.max_step
        return min(math.cbrt(self.tolerance) * flow.longest_step(size), self.max_step, flow.whole_time)

    def first_step(self, flow: Flow, residual: float, hop: float) -> float:
        """The time in which the law undoes the largest disequilibrium, or that of one arc if that is less."""
        if np.isinf(self.tolerance):
            return self.max_step
        size = max(min(residual, hop), _TINY)
        return size / flow.speed(size)


@dataclass(frozen=True, eq=False)
class State:
    """How the rows stand at clock reading ``tau``, and how many steps were tried in vain until then."""

    tau: float
    standing: Standing
    rejected: int = 0

    @property
    def y(self) -> Floats:
        """(R + S,) the states; not to be written to."""
        return self.standing.y

    @property
    def residual(self) -> float:
        """max |xhat_i|, the Bellman residual."""
        return self.standing.residual

    @property
    def resolution(self) -> float:
        """The least |xhat| that says anything: what steps leave is rounded. The start is exact."""
        return _ROUNDED * self.standing.largest if self.tau > 0.0 else 0.0


def run(problem: Problem, flow: Flow, y0: Floats, solver: Splitting, until_tau: float = np.inf) -> Iterator[State]:
    """The start, then the state after every step of dy/dtau = -phi(y - m(y)), without end; one is at ``until_tau``."""
    parents, hop = parents_of(problem, flow), problem.mean_cost(y0)
    state = State(0.0, parents.standing(y0))
    dtau = solver.first_step(flow, state.residual, hop)
    rejected = 0
    while True:
        yield state
        size = _measured_by(state, hop)
        allowed, shortest = solver.allowed(flow, size), _shortest_step(flow, state)
        dtau = min(max(dtau, shortest), solver.longest_step(flow, state.residual))
        while True:  # ends: a rejected step is a tenth shorter at least, and the shortest is accepted
            step, reached = dtau, state.tau + dtau
            if state.tau < until_tau <= state.tau + 1.0001 * dtau:
                step, reached = until_tau - state.tau, until_tau
            standing, share = parents.step(state.standing, step, size)
            if share <= allowed or step <= shortest:
                break
            dtau = max(step * max(0.2, _SAFETY * allowed / share), shortest)
            rejected += 1
        state = State(reached, standing, rejected)
        dtau = max(dtau, step) * (_SAFETY * allowed / share if share > 0.5 * _SAFETY * allowed else 2.0)


def _measured_by(state: State, hop: float) -> float:
    """The disequilibrium that an error of the next step is measured by, see :meth:`Parents.step`."""
    largest = state.standing.largest
    return max(min(state.residual, max(hop, _FINEST * largest)), _ROUNDED * largest)


def _shortest_step(flow: Flow, state: State) -> float:
    """The step that is taken whatever it may err by: it is nothing beside tau, or beside what is left of it."""
    left = state.residual / flow.speed(state.residual) if state.residual else 0.0
    return max(_EPS * state.tau, _FINEST * left, _TINY)


class Parents:
    """Parent values of all rows, and steps of the splitting method by them, for every kernel and law."""

    def __init__(self, problem: Problem, flow: Flow) -> None:
        self.problem, self.flow = problem, flow

    def __call__(self, y: Floats) -> Floats:
        """(R,) m_i at states ``y``."""
        return self.problem.parent_values(y)

    def standing(self, y: Floats) -> Standing:
        """How the rows stand at states ``y``."""
        return self.problem.standing(y)

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def step(self, at: Standing, dtau: float, size: float) -> tuple[Standing, float]:
        """How the rows stand after ``dtau``, and how far off that may be, as a share of ``size`` + |xhat_i|.

        Parent values are taken about half a step on, see :meth:`Flow.half_step`. Had m not been moved by delta, the
        step would have ended delta (1 - rho) elsewhere, rho the share of y_i - m_i that the flow leaves over. The law
        undoes an error of ``size`` in size / phi(size), so this share counts as a time: ``size`` is the largest
        disequilibrium, or an average arc cost if smaller.
        """
        rows, before = at.y[: self.problem.n_rows], at.y[: self.problem.n_rows] - at.xhat
        sketch = before + self.flow.fastest(at.xhat, self.flow.half_step(dtau, size))
        m = self(self.problem.with_sources(sketch))
        s = rows - m
        left = self.flow.advance(s, dtau)
        there = m + left
        held = (there == rows) & (s != 0.0)  # or rounding would hold them there for ever
        there[held] = np.nextafter(rows[held], m[held])
        scale = size + np.abs(at.xhat)
        off = np.abs((m - before) * (s - left)) / (scale * np.abs(s)) + self.flow.miss(s, left, dtau) / scale
        return self.standing(self.problem.with_sources(there)), float(np.fmax.reduce(off, initial=0.0))


class AffineParents(Parents):
    """The same in compiled code, for the kernels and the laws of the paper."""

    def __init__(self, problem: Problem, flow: Flow, native: NativeFlow, arcs: AffineArcs) -> None:
        super().__init__(problem, flow)
        self._native, self._arcs = native, NativeArcs(problem.starts, problem.heads, arcs.slope, arcs.offset)

    def __call__(self, y: Floats) -> Floats:
        return self._arcs.parent_values(None, y)

    def standing(self, y: Floats) -> Standing:
        return Standing(y, *self._arcs.standing(None, y)[:4])

    def step(self, at: Standing, dtau: float, size: float) -> tuple[Standing, float]:
        half = self.flow.half_step(dtau, size)
        y, xhat, *numbers, _, off = self._arcs.step(self._native, None, at.y, at.xhat, half, dtau, size)
        return Standing(y, xhat, *numbers), off


def parents_of(problem: Problem, flow: Flow) -> Parents:
    """Parent values of all rows, compiled where the kernel is affine and the law no user's."""
    if not isinstance(problem.arcs, AffineArcs) or flow.compiled is None:
        return Parents(problem, flow)
    return AffineParents(problem, flow, flow.compiled, problem.arcs)
