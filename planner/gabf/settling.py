"""When a run has settled: proved while it runs, without the oracle, and dated once its end is known."""

from __future__ import annotations

import math

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import AssumptionError
from planner.gabf.assumptions import Premises
from planner.gabf.flows import Flow
from planner.gabf.laws import Law, control_input
from planner.gabf.problem import Problem
from planner.gabf.solvers import State


def error_bound(problem: Problem, premises: Premises, state: State) -> float:
    """A proved bound on max |y - x*| from the Bellman residual r, +inf where nothing is proved (r >= zeta).

    With r < zeta a minimising neighbour j of i has y_j <= y_i - zeta + r < y_i, so these neighbours form no
    cycle and lead to a source: x_i* <= y_i + r (1 + L + ... + L^(N-1)). Along an optimal path y_i <= x_i* +
    the same sum. N bounds the hops of both by the rows, and by how often zeta - r fits into the range of y.
    Ours.
    """
    y, residual = state.y, state.residual
    if residual == 0.0:
        return 0.0
    if residual >= premises.zeta:
        return math.inf
    span = float(y.max() - y.min()) + residual
    hops = min(float(problem.n_rows), math.ceil(span / (premises.zeta - residual)) + 1.0)
    if premises.L <= 1.0:
        return residual * hops
    growth = hops * math.log(premises.L)
    return math.inf if growth > 700 else residual * math.expm1(growth) / (premises.L - 1.0)


def require_rooted(problem: Problem, y: Floats) -> None:
    """Raise AssumptionError unless a residual of zero proves y = x*.

    It does if every arc visibly adds to its head's value, and also if tight arcs (y_i = f_i(y_j, w_ij)) lead from every
    node to a source. Neither may hold for starts below x* on arcs whose cost vanishes beside x in double precision.
    """
    heads = y[problem.heads]
    values = problem.arcs(heads)
    if (values > heads).all():
        return
    tight = values == y[problem.owners]
    unrooted = np.flatnonzero(problem.hops_along(tight) < 0)
    if unrooted.size:
        i = int(unrooted[0])
        raise AssumptionError(
            f"node {problem.nodes[i]} is stuck at {y[i]:g}: an arc cost on its path vanishes beside that in "
            "double precision, so the kernel is not progressive; start from overestimate(net), or rescale"
        )


class Course:
    """What is remembered of a run's states: their extremes, and those since the last one that was provably not settled.

    All that the settling time depends on are the latter. If every error were within the tolerance band, the residual
    would be at most (1 + L) times the widest band; a larger one, ``clear_above``, clears their list. So it holds a
    handful of states under the laws that end in finite time.
    """

    def __init__(self, premises: Premises, tolerance: float):
        self._tolerance = tolerance
        widest = tolerance * max(1.0, abs(premises.lower), abs(premises.upper))
        self.clear_above = (1.0 + premises.L) * widest
        self.lowest, self.highest = math.inf, -math.inf
        self._states: list[State] = []
        self._readings: list[tuple[float, float]] = []

    def add(self, state: State) -> None:
        """Remember the state that comes next."""
        lowest, highest = state.standing.lowest, state.standing.highest
        self.lowest, self.highest = min(self.lowest, lowest), max(self.highest, highest)
        self._readings.append((state.tau, state.residual if state.residual > state.resolution else 0.0))
        if state.residual > self.clear_above:
            self._states.clear()
        self._states.append(state)

    def largest_input(self, law: Law) -> float:
        """The largest |dx_i/dt| of the states: where the residual is largest, as the gain is common to all nodes."""
        tau, residual = np.array(self._readings).T
        return float(-control_input(law, tau, residual).min(initial=0.0))

    def settling_tau(self, y_star: Floats, flow: Flow) -> float:
        """The first tau after which all errors stay in the band, placed in its step by the law's decay."""
        scale = np.maximum(1.0, np.abs(y_star))
        tau = [state.tau for state in self._states]
        error = [float((np.abs(state.y - y_star) / scale).max()) for state in self._states]
        outside = np.flatnonzero(np.array(error) > self._tolerance)
        if outside.size == 0:
            return tau[0]
        k = int(outside[-1])
        if k + 1 == len(tau):
            return tau[k]
        worst = float(scale[np.argmax(np.abs(self._states[k].y - y_star) / scale)])
        first, second, width = (worst * share for share in (*error[k : k + 2], self._tolerance))
        return tau[k] + _inside(tau[k + 1] - tau[k], first, second, width, flow)


def _inside(step: float, first: float, second: float, width: float, flow: Flow) -> float:
    """How far into a step the worst node's error falls to ``width``, from ``first`` to ``second``."""
    fall = flow.time_between(first, width)
    whole = flow.time_between(first, second) if second > 0.0 else step
    return step * min(1.0, fall / whole) if whole > 0.0 else step
