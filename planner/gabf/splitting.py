"""The structure-preserving solver: scalar flows towards parent values of the middle of a step."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.gabf.flows import Flow
from planner.gabf.kernels import AffineArcs
from planner.gabf.problem import ROUNDED, Problem, State
from planner.native.compiled import NativeArcs, NativeFlow

_EPS, _TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)
_SAFETY = 0.9
_FINEST = 1e-12  # resolution of xhat as a share of states, of steps as a share of the law's time: else steps stall


@dataclass(frozen=True)
class Splitting:
    """For a constant parent value m_i = min_j f_i(y_j, w_ij), y_i - m_i follows a known scalar flow.

    A step takes m from about half a step (order 2) and flows across the whole. It has no stability limit, no chatter at
    y_i = m_i, and ends on the fixed point to the last bit: large steps become Bellman-Ford sweeps. ``tolerance`` is the
    error in tau that one step may make, in units of the law's own pace and estimated from the change of m: a smaller
    one takes more steps and estimates the settling time better (at 0.05 mostly within 3 %, at 0.005 within 0.5 %); the
    final x is the same. :attr:`planner.gabf.CostToGo.settling_tau_bracket` is the proved settling time. ``max_step``
    bounds a step in tau; with an infinite tolerance every step has that size. No tolerance sees a parent that takes
    over in the second half of a step, as it has not moved m before: for saved states that are right to some digits,
    give a ``max_step`` too.

    >>> network = gabf.Network.from_arcs([1], [0], [1.0], sources=[0], n_nodes=2)
    >>> round(gabf.solve(network, "nominal", x0=2.0, solver=gabf.Splitting(1e-3)).settling_tau, 2)  # ln 1e9
    20.72
    """

    tolerance: float = 0.05
    max_step: float = np.inf

    def __post_init__(self) -> None:
        if not (self.tolerance > 0 and self.max_step > 0):
            raise OptionError(f"tolerance and max_step must be positive, got {self.tolerance, self.max_step}.")
        if np.isinf(self.tolerance) and np.isinf(self.max_step):
            raise OptionError("an infinite tolerance needs a finite max_step, the size of every step.")

    def longest_step(self, flow: Flow, size: float) -> float:
        """Return the longest step: Strang's rule errs by about (dtau / longest)^3 longest in tau."""
        if np.isinf(self.tolerance):
            return self.max_step
        return min(math.cbrt(self.tolerance) * flow.longest_step(size), self.max_step, flow.whole_time)


def run(problem: Problem, flow: Flow, y0: Floats, solver: Splitting, until_tau: float = np.inf) -> Iterator[State]:
    """Yield the start, then the state after every step of dy/dtau = -phi(y - m(y)).

    One state is at ``until_tau``.
    """
    parents, hop = make_parents(problem, flow), problem.mean_cost(y0)
    state = parents.state(y0)
    size, rejected = max(min(state.residual, hop), _TINY), 0
    # first, the time in which the law undoes the largest disequilibrium, or that of one arc if that is less
    dtau = solver.max_step if np.isinf(solver.tolerance) else size / flow.speed(size)
    while True:
        yield state
        residual, largest = state.residual, state.largest
        # the scale of errors, and a step that is negligible next to tau and to the time that is left
        size = max(min(residual, max(hop, _FINEST * largest)), ROUNDED * largest)
        allowed = solver.tolerance * flow.urgency(size) if size else np.inf
        left = residual / flow.speed(residual) if residual else 0.0
        shortest = max(_EPS * state.tau, _FINEST * left, _TINY)
        dtau = min(max(dtau, shortest), solver.longest_step(flow, residual))
        while True:  # ends: a rejected step is a tenth shorter at least, and the shortest is accepted
            step, reached = dtau, state.tau + dtau
            if state.tau < until_tau <= state.tau + 1.0001 * dtau:
                step, reached = until_tau - state.tau, until_tau
            there, share = parents.step(state, step, size)
            if share <= allowed or step <= shortest:
                break
            dtau = max(step * max(0.2, _SAFETY * allowed / share), shortest)
            rejected += 1
        state = there._replace(tau=reached, rejected=rejected)
        dtau = max(dtau, step) * (_SAFETY * allowed / share if share > 0.5 * _SAFETY * allowed else 2.0)


class Parents:
    """Parent values of all rows, and steps of the splitting method, for every kernel and law."""

    def __init__(self, problem: Problem, flow: Flow) -> None:
        self.problem, self.flow = problem, flow

    def __call__(self, y: Floats) -> Floats:
        """Return (R,) m_i at states ``y``."""
        return self.problem.parent_values(y)

    def state(self, y: Floats) -> State:
        """Return the state of the rows at ``y``."""
        rows, xhat = y[: self.problem.n_rows], self.problem.disequilibrium(y)
        lowest, highest = float(rows.min(initial=np.inf)), float(rows.max(initial=-np.inf))
        return State(y, xhat, float(np.abs(xhat).max(initial=0.0)), lowest, highest)

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def step(self, at: State, dtau: float, size: float) -> tuple[State, float]:
        """Return the state ``dtau`` later, and its error as a share of ``size`` + |xhat_i|.

        Parent values are taken about half a step on, see :meth:`Flow.half_step`. Without the change delta of m, the
        step would end delta (1 - rho) elsewhere, rho the share of y_i - m_i that the flow leaves. The law undoes an
        error of ``size`` in size / phi(size), so this share counts as a time: ``size`` is the largest disequilibrium,
        or an average arc cost if smaller.
        """
        rows = at.y[: self.problem.n_rows]
        before = rows - at.xhat
        m = self(self.problem.with_sources(before + self.flow.fastest(at.xhat, self.flow.half_step(dtau, size))))
        s = rows - m
        left = self.flow.advance(s, dtau)
        there = m + left
        stuck = (there == rows) & (s != 0.0)  # by rounding
        there[stuck] = np.nextafter(rows[stuck], m[stuck])
        scale = size + np.abs(at.xhat)
        off = np.abs((m - before) * (s - left)) / (scale * np.abs(s)) + self.flow.miss(s, left, dtau) / scale
        return self.state(self.problem.with_sources(there)), float(np.fmax.reduce(off, initial=0.0))


class AffineParents(Parents):
    """:class:`Parents` in compiled code, for the kernels and the laws of the paper."""

    def __init__(self, problem: Problem, flow: Flow, native: NativeFlow, arcs: AffineArcs) -> None:
        super().__init__(problem, flow)
        self._native, self._arcs = native, NativeArcs(problem.starts, problem.heads, arcs.slope, arcs.offset)

    def __call__(self, y: Floats) -> Floats:
        return self._arcs.parent_values(None, y)

    def state(self, y: Floats) -> State:
        return State(y, *self._arcs.standing(None, y)[:4])

    def step(self, at: State, dtau: float, size: float) -> tuple[State, float]:
        half = self.flow.half_step(dtau, size)
        y, xhat, residual, low, high, _, off = self._arcs.step(self._native, None, at.y, at.xhat, half, dtau, size)
        return State(y, xhat, residual, low, high), off


def make_parents(problem: Problem, flow: Flow) -> Parents:
    """Return the parent values of all rows, compiled for affine kernels and the paper's laws."""
    if not isinstance(problem.arcs, AffineArcs) or flow.compiled is None:
        return Parents(problem, flow)
    return AffineParents(problem, flow, flow.compiled, problem.arcs)
