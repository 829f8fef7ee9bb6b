"""The structure-preserving solver: exact scalar flows around parent values that a half step has moved."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.gabf.flows import Flow
from planner.gabf.parents import parents_of
from planner.gabf.problem import Problem
from planner.gabf.solvers import ROUNDED, Solver, State, Targets

_EPS, _TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)
SAFETY = 0.9
_MOST = 2.5
"""Shares of ``tolerance`` that a step may err by of a disequilibrium that the law undoes in no time: without it, rises
that step as fast as they may are 100 times too slow where exponents are far from 1.
"""
_FINEST = 1e-12
"""What no double resolves: of the states, the disequilibrium that steps are measured by; of the time in which the law
undoes the largest one, a step. Without it, steps shrink for ever where states are 1e13 times an arc's cost.
"""
RETIRE_EVERY = 8
"""Steps between two looks for rows that rest for good."""


@dataclass(frozen=True)
class Splitting(Solver):
    """Hold each parent value m_i = min_j f_i(y_j, w_ij): then y_i - m_i follows a scalar equation of known flow.

    A step takes m from about half a step (order 2) and flows across the whole. It has no stability limit, no
    chatter at y_i = m_i, and ends on the fixed point to the last bit: large steps become Bellman-Ford
    sweeps. ``tolerance`` is the error in tau that one step may make, in units of the law's own pace and
    estimated from how far m moved: a smaller one takes more steps and places the settling time better (at
    0.05 mostly within 3 %, at 0.005 within 0.5 %); the final x is the same. What is proved of the settling
    time is :attr:`planner.gabf.CostToGo.settling_tau_bracket`. ``max_step`` bounds a step in tau; with an
    infinite tolerance every step has that size. A parent that takes over in the second half of a step has not moved m
    before, so no tolerance sees it: where saved states have to be right to some digits, give a ``max_step`` too.

        solve(net, solver=Splitting(tolerance=1e-3))
    """

    tolerance: float = 0.05
    max_step: float = np.inf
    order: ClassVar[int] = 2
    exact_rest: ClassVar[bool] = True
    name: ClassVar[str] = "splitting"

    def __post_init__(self) -> None:
        if not (self.tolerance > 0 and self.max_step > 0):
            raise OptionError("tolerance and max_step of the splitting solver must be positive")
        if np.isinf(self.tolerance) and np.isinf(self.max_step):
            raise OptionError("an infinite tolerance needs a finite max_step, the size of every step")

    def states(self, problem: Problem, flow: Flow, y0: Floats, targets: Floats) -> Iterator[State]:
        """See :class:`planner.gabf.solvers.Solver`."""
        return self.steps(Field(problem, flow, y0), flow, problem.mean_cost(y0), targets)

    def steps(self, field: Field, flow: Flow, hop: float, targets: Floats) -> Iterator[State]:
        """The same for states wherever they are kept; ``hop`` is their mean cost, see :class:`Problem`."""
        landing = Targets(targets)
        tau, count, steps, rejected = 0.0, 1, 0, 0
        state = field.state(tau, count, rejected)
        dtau = self._first_step(flow, state.residual, hop)
        while True:
            yield state
            steps += 1
            if steps % RETIRE_EVERY == 0:
                field.retire()
            size = _measured_by(state, hop)
            allowed, shortest = self._allowed(flow, size), _shortest_step(flow, state)
            dtau = min(max(dtau, shortest), self._longest_step(flow, state.residual))
            while True:  # ends: a rejected step is a tenth shorter at least, and the shortest is accepted
                step, reached = landing.clip(tau, dtau)
                share = field.attempt(step, size)
                count += 1
                if share <= allowed or step <= shortest:
                    break
                dtau = max(step * max(0.2, SAFETY * allowed / share), shortest)
                rejected += 1
            field.accept()
            tau, count = reached, count + 1
            state = field.state(tau, count, rejected)
            growth = SAFETY * allowed / share if share > 0.5 * SAFETY * allowed else 2.0
            dtau = max(dtau, step) * growth

    def _allowed(self, flow: Flow, size: float) -> float:
        """The share of a disequilibrium of ``size`` that a step may err by.

        It is ``tolerance`` in tau, in units of the law's own pace, and at most a share of the time in which the law
        undoes the disequilibrium.
        """
        return self.tolerance * min(flow.pace * flow.speed(size) / size, _MOST) if size else np.inf

    def _longest_step(self, flow: Flow, size: float) -> float:
        """Strang's rule itself errs by about (dtau / longest)^3 longest in tau. At last, nothing is left to be done."""
        if np.isinf(self.tolerance):
            return self.max_step
        return min(math.cbrt(self.tolerance) * flow.longest_step(size), self.max_step, flow.whole_time)

    def _first_step(self, flow: Flow, residual: float, hop: float) -> float:
        if np.isinf(self.tolerance):
            return self.max_step
        size = max(min(residual, hop), _TINY)
        return size / flow.speed(size)


def _measured_by(state: State, hop: float) -> float:
    """The disequilibrium that an error of the next step is measured by, see :meth:`Parents.advance`."""
    largest = state.standing.largest
    return max(min(state.residual, max(hop, _FINEST * largest)), ROUNDED * largest)


def _shortest_step(flow: Flow, state: State) -> float:
    """The step that is taken whatever it may err by: it is nothing beside tau, or beside what is left of it."""
    left = state.residual / flow.speed(state.residual) if state.residual else 0.0
    return max(_EPS * state.tau, _FINEST * left, _TINY)


class Field:
    """The states of a run in one array, and one step of them; subclasses keep them elsewhere."""

    def __init__(self, problem: Problem, flow: Flow, y0: Floats):
        self._flow, self._parents = flow, parents_of(problem)
        self._here = self._next = self._parents.standing(y0)

    def state(self, tau: float, evaluations: int, rejected: int = 0) -> State:
        """The states as they are."""
        return State(tau, self._here, evaluations, rejected)

    def attempt(self, dtau: float, size: float) -> float:
        """Try a step, and how far off it may be, see :meth:`Parents.advance`."""
        self._next, share = self._parents.step(self._flow, self._here, dtau, size)
        return share

    def accept(self) -> None:
        """Take the step that was tried last."""
        self._here = self._next

    def retire(self) -> None:
        """Stop looking at rows that rest for good."""
        self._parents = self._parents.retire(self._here, self._here.lowest_moving)
