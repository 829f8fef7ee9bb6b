"""Run a law on a network until its cost-to-go is proved settled."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import OptionError
from planner.base.kinds import checks_kinds
from planner.gabf.assumptions import Premises, pack_start, premises, require_overestimate
from planner.gabf.laws import Law, SingularityFree
from planner.gabf.network import Network
from planner.gabf.oracle import oracle
from planner.gabf.partitioned.cut import Partition
from planner.gabf.partitioned.run import Exchanged, partitioned_field
from planner.gabf.problem import Problem, reduce
from planner.gabf.result import CostToGo, Ending, Trajectory
from planner.gabf.saving import Recorder, Save
from planner.gabf.settling import EndPhase, Extremes, error_bound, require_rooted
from planner.gabf.solvers import Solver, State, mean_cost
from planner.gabf.splitting import Splitting


@checks_kinds
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
    partition: Partition | None = None,
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
    ``until_tau`` bound the work. ``partition``: cut into blocks, here or on a cluster; x and all else come out the
    same to the bit.

    Raises AssumptionError, naming node and arc, where the kernel is not increasing and progressive on the
    interval that the run stays in, where a start lies outside the kernel's domain, and where the
    prescribed-time law does not start above x*.

        result = solve(net, law=SingularityFree(T=2.0))
        result.x, result.settling_time, result.outcome
    """
    limits = Limits(settle_tolerance, max_steps, until_tau)
    law = SingularityFree() if law is None else law
    solver = Splitting() if solver is None else solver
    problem = reduce(net)
    y0 = pack_start(problem, x0)
    bounds = premises(problem, y0)
    if law.needs_overestimate and x0 is not None:
        require_overestimate(problem, y0, problem.pack(oracle(net)), law.name)
    recorder = Recorder(save, problem, law)
    if partition is None:
        run = _run(partial(solver.states, problem, law.flow, y0), problem, law, solver, bounds, recorder, limits)
    else:
        run = _run_on_blocks(problem, law, solver, y0, bounds, recorder, limits, partition)
    return _result(problem, law, solver, y0, bounds, run, settle_tolerance)


@dataclass(frozen=True)
class Limits:
    """What counts as settled, and how much work may be spent on it."""

    tolerance: float
    max_steps: int
    until_tau: float

    def __post_init__(self) -> None:
        if not (self.tolerance > 0 and self.until_tau >= 0 and self.max_steps >= 0):
            raise OptionError("settle_tolerance must be positive, max_steps and until_tau not negative")

    def reached(self, tried: int, tau: float) -> bool:
        return tried >= self.max_steps or tau >= self.until_tau


@dataclass(frozen=True, eq=False)
class _Run:
    last: State
    steps: int
    error_bound: float
    extremes: tuple[float, float, float]
    dated_tau: float | None
    trajectory: Trajectory | None
    exchanged: Exchanged | None = None


def _run_on_blocks(
    problem: Problem,
    law: Law,
    solver: Solver,
    y0: Floats,
    bounds: Premises,
    recorder: Recorder,
    limits: Limits,
    partition: Partition,
) -> _Run:
    if not isinstance(solver, Splitting) or recorder.keeps:
        raise OptionError("blocks run the splitting solver and keep no trajectory: leave solver and save out.")
    clear_above = EndPhase(bounds, limits.tolerance).clear_above
    with partitioned_field(problem, law.flow, y0, partition, clear_above) as field:
        states = partial(solver.steps, field, law.flow, mean_cost(problem, y0))
        run = _run(states, problem, law, solver, bounds, recorder, limits)
        return replace(run, exchanged=field.exchanged)


def _run(
    states_from: Callable[[Floats], Iterator[State]],
    problem: Problem,
    law: Law,
    solver: Solver,
    bounds: Premises,
    recorder: Recorder,
    limits: Limits,
) -> _Run:
    end_phase, extremes = EndPhase(bounds, limits.tolerance), Extremes()
    targets = np.unique(np.append(recorder.targets, limits.until_tau))
    states = states_from(targets)
    step = -1
    while True:
        step, state = step + 1, next(states)
        end_phase.add(state)
        extremes.add(state)
        recorder.offer(step, state)
        settled = _is_settled(problem, solver, bounds, state, limits)
        if settled or limits.reached(step + state.rejected, state.tau):
            break
    proved = error_bound(problem, bounds, state)
    y_star = state.y if state.residual == 0.0 or not settled else problem.pack(oracle(problem.network))
    date = end_phase.settling_tau(y_star, law.flow) if settled else None
    return _Run(state, step, proved, extremes.over(law), date, recorder.trajectory(state, settled))


def _is_settled(problem: Problem, solver: Solver, bounds: Premises, state: State, limits: Limits) -> bool:
    """Solvers that come to rest exactly run until they do; for others the error must be proved small."""
    if state.residual == 0.0:
        require_rooted(problem, state.y)
        return True
    return not solver.exact_rest and error_bound(problem, bounds, state) <= limits.tolerance


def _result(
    problem: Problem, law: Law, solver: Solver, y0: Floats, bounds: Premises, run: _Run, tolerance: float
) -> CostToGo:
    return CostToGo(
        x=_frozen(problem.unpack(run.last.y)),
        x0=_frozen(problem.unpack(y0)),
        law=law,
        problem=problem,
        premises=bounds,
        outcome=Ending.BUDGET_SPENT if run.dated_tau is None else Ending.SETTLED,
        dated_tau=run.dated_tau,
        end_tau=run.last.tau,
        residual=run.last.residual,
        lowest=run.extremes[0],
        highest=run.extremes[1],
        largest_input=run.extremes[2],
        error_bound=run.error_bound,
        settle_tolerance=tolerance,
        steps=run.steps,
        evaluations=run.last.evaluations,
        solver=solver.name,
        trajectory=run.trajectory,
        exchanged=run.exchanged,
    )


def _frozen(array: Floats) -> Floats:
    array.setflags(write=False)
    return array
