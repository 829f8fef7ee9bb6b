"""Run a law on a network until its cost-to-go is proved settled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.gabf.assumptions import Premises, pack_start, premises, require_overestimate
from planner.gabf.laws import Law, SingularityFree
from planner.gabf.network import Network
from planner.gabf.oracle import oracle
from planner.gabf.problem import Problem, reduce
from planner.gabf.result import CostToGo, Ending
from planner.gabf.saving import Recorder, Save
from planner.gabf.settling import Course, error_bound, require_rooted
from planner.gabf.solvers import Solver, State
from planner.gabf.splitting import Splitting


def solve(
    net: Network,
    law: Law | None = None,
    x0: Floats | float | None = None,
    solver: Solver | None = None,
    save: Save | None = None,
    *,
    settle_tolerance: float = 1e-9,
    max_steps: int = 300_000,
    until_tau: float = np.inf,
) -> CostToGo:
    """The cost-to-go x of every node under ``law`` (default :class:`SingularityFree`), from the start ``x0``.

    ``x0``: (n,) states, one number for all, or None for :func:`overestimate`, from which every law settles.
    Starting from an earlier ``result.x`` after weights changed is how GABF heals; nodes that were unreachable
    (+inf) then need a number. Values at sources and at nodes that reach no source are ignored. ``solver``:
    default :class:`Splitting`. ``save``: :class:`EverySteps` or :class:`AtTimes`; nothing is kept without.
    ``settle_tolerance`` defines settled, relative to max(1, |x_i*|); a larger one settles earlier and changes
    neither x nor the steps of the splitting solver, which ends at a residual of exactly 0. When it settled is
    dated by the run's steps, within ``result.settling_tau_bracket``, which is proved. References end
    where :func:`planner.gabf.settling.error_bound` proves the tolerance. ``max_steps``, rejected ones too, and
    ``until_tau`` bound the work.

    Raises AssumptionError, naming node and arc, where the kernel is not increasing and progressive on the
    interval that the run stays in, where a start lies outside the kernel's domain, and where the
    prescribed-time law does not start above x*.

        result = solve(net, law=SingularityFree(T=2.0))
        result.x, result.settling_time, result.outcome
    """
    if not (settle_tolerance > 0 and until_tau >= 0 and max_steps >= 0):
        raise OptionError("settle_tolerance must be positive, max_steps and until_tau not negative")
    law = SingularityFree() if law is None else law
    solver = Splitting() if solver is None else solver
    problem = reduce(net)
    y0 = pack_start(problem, x0)
    bounds = premises(problem, y0)
    if law.needs_overestimate and x0 is not None:
        require_overestimate(problem, y0, problem.pack(oracle(net)), law.name)
    recorder = Recorder(save, problem, law)
    return _Run(problem, law, solver, y0, bounds, recorder, settle_tolerance, max_steps, until_tau).follow()


@dataclass(frozen=True, eq=False)
class _Run:
    """A law on a network from a packed start, with all that decides when it ends."""

    problem: Problem
    law: Law
    solver: Solver
    y0: Floats
    bounds: Premises
    recorder: Recorder
    tolerance: float
    max_steps: int
    until_tau: float

    def follow(self) -> CostToGo:
        """Step until the run has settled or its budget is spent, and return the cost-to-go there."""
        course, recorder = Course(self.bounds, self.tolerance), self.recorder
        readings = np.array(sorted({*recorder.targets.tolist(), self.until_tau}), dtype=np.float64)
        states = self.solver.states(self.problem, self.law.flow, self.y0, readings)
        step = -1
        while True:
            step, state = step + 1, next(states)
            course.add(state)
            recorder.offer(step, state)
            settled = self._is_settled(state)
            if settled or step + state.rejected >= self.max_steps or state.tau >= self.until_tau:
                break
        known = state.residual == 0.0 or not settled  # x*, or not to be compared with
        y_star = state.y if known else self.problem.pack(oracle(self.problem.network))
        return CostToGo(
            x=_frozen(self.problem.unpack(state.y)),
            x0=_frozen(self.problem.unpack(self.y0)),
            law=self.law,
            problem=self.problem,
            premises=self.bounds,
            outcome=Ending.SETTLED if settled else Ending.BUDGET_SPENT,
            dated_tau=course.settling_tau(y_star, self.law.flow) if settled else None,
            end_tau=state.tau,
            residual=state.residual,
            lowest=course.lowest,
            highest=course.highest,
            largest_input=course.largest_input(self.law),
            error_bound=error_bound(self.problem, self.bounds, state),
            settle_tolerance=self.tolerance,
            steps=step,
            evaluations=state.evaluations,
            solver=self.solver.name,
            history=recorder.history(state, settled),
        )

    def _is_settled(self, state: State) -> bool:
        """Solvers that come to rest exactly run until they do; for others the error must be proved small."""
        if state.residual == 0.0:
            require_rooted(self.problem, state.y)
            return True
        return not self.solver.exact_rest and error_bound(self.problem, self.bounds, state) <= self.tolerance


def _frozen(array: Floats) -> Floats:
    array.setflags(write=False)
    return array
