"""Remark (implementation): explicit and implicit methods in t, up to T_p and just before it, tried and judged."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from planner import gabf
from planner.reproduce.laws.cases import STARTS, T_P, LawCase, Measurement, on_graphs
from planner.reproduce.random_graphs import RandomGraph
from planner.reproduce.report import Verdict, spread
from planner.reproduce.textbook import Initial, SolverRun, backward_euler, forward_euler, runge_kutta

PRACTICAL_END = 0.9975 * T_P
"""Where a run with ode45 stops short of T_p, s."""

COARSE, FINE = 1_000, 20_000
"""Numbers of equal steps from 0 to T_p: 4 ms and 0.2 ms."""

WELL_BEFORE = 0.9 * T_P
"""What "well before T_p" is taken to mean, s."""

ACCURATE = 1e-3
"""The error that a run in practice may have, km: a metre in ten kilometres."""

FIRST = LawCase(gabf.PrescribedTime(T=T_P, h=1.0, gamma=1.0), "above")
ABOVE = LawCase(gabf.SingularityFree(T=T_P, h=1.0, gamma=10.0), "above")
BELOW = LawCase(gabf.SingularityFree(T=T_P, h=1.0, gamma=10.0), "below")

Method = Callable[[Initial], SolverRun]

TRIALS: tuple[tuple[LawCase, str, Method], ...] = (
    (ABOVE, f"forward Euler, {COARSE} steps", lambda run: forward_euler(run, COARSE)),
    (ABOVE, f"forward Euler, {FINE} steps", lambda run: forward_euler(run, FINE)),
    (ABOVE, f"backward Euler, {COARSE} steps", lambda run: backward_euler(run, COARSE)),
    (ABOVE, "RK45, rtol 1e-6, up to T_p", lambda run: runge_kutta(run, T_P)),
    (BELOW, "RK45, rtol 1e-6, up to 0.9975 T_p", lambda run: runge_kutta(run, PRACTICAL_END)),
    (FIRST, f"forward Euler, {COARSE} steps", lambda run: forward_euler(run, COARSE)),
    (FIRST, f"backward Euler, {COARSE} steps", lambda run: backward_euler(run, COARSE)),
    (FIRST, "RK45, rtol 1e-6, up to T_p", lambda run: runge_kutta(run, T_P)),
)


@dataclass(frozen=True)
class Trial:
    """One method on one graph, with its errors max_i |x_i - x_i*| in km.

    ``best``: the smallest error of all steps; ``last``: at the end; ``practical``: at the last step by 0.9975 T_p.
    ``reached``: it came to the end of its interval.
    """

    graph: int
    case: LawCase
    name: str
    best: float
    last: float
    practical: float
    reached: bool
    evaluations: int


def run_trials(graph: RandomGraph, index: int) -> Iterator[tuple[Trial, SolverRun]]:
    """Every method of ``TRIALS`` in turn on the graph of number ``index``."""
    for case, name, method in TRIALS:
        run = method(Initial(graph.network, case.law, case.x0, graph.x_star))
        practical = run.until(PRACTICAL_END)
        yield Trial(index, case, name, run.best, run.last, practical, run.reached, run.evaluations), run


def remark_verdicts(trials: Sequence[Trial], runs: Sequence[Measurement]) -> tuple[Verdict, ...]:
    """The sentences of remark (implementation); counts are of graphs."""
    free = [run for run in runs if run.case.law.name == "singularity-free"]
    early = (_well_before([run for run in free if run.case.start == start], start) for start in STARTS)
    return (*_solvers(trials), *early)


def _solvers(trials: Sequence[Trial]) -> Iterator[Verdict]:
    """To fail is to end far off x* after having been a hundred times closer, at every step size tried.

    Preferred: accurate at T_p, in both laws, in steps with which the explicit method fails in the second. Practical:
    accurate where a run with ode45 stops, from both starts.
    """

    def of(case: LawCase, method: str) -> list[Trial]:
        return [trial for trial in trials if trial.case == case and trial.name.startswith(method)]

    euler = of(ABOVE, "forward Euler")
    notes = [f"{name}: {_errors([t for t in euler if t.name == name])}" for name in sorted({t.name for t in euler})]
    for case in (ABOVE, FIRST):
        rk = of(case, "RK45")
        notes.append(f"RK45 gives up before T_p in {sum(not t.reached for t in rk)} of {len(rk)} ({case.law.name} law)")
    first = _errors(of(FIRST, "forward Euler"))
    yield on_graphs(
        "Explicit methods may fail near the prescribed time T_p even with very small time steps.",
        euler,
        lambda trial: trial.last > max(ACCURATE, 100.0 * trial.best),
        "; ".join(notes) + f"; under the prescribed-time law forward Euler does not fail: {first}",
    )
    implicit = {case.law.name: of(case, "backward Euler") for case in (ABOVE, FIRST)}
    yield on_graphs(
        "Implicit methods, such as the backward Euler method, are generally preferred.",
        [trial for of_law in implicit.values() for trial in of_law],
        lambda trial: trial.last <= ACCURATE,
        "; ".join(f"{law} law, {of_law[0].name}: {_errors(of_law)}" for law, of_law in implicit.items() if of_law),
    )
    above, below = of(ABOVE, "RK45"), of(BELOW, "RK45")
    yield on_graphs(
        "Explicit solvers such as ode45 remain practical (SciPy's RK45, rtol 1e-6, stopped at 0.9975 T_p).",
        [*above, *below],
        lambda trial: trial.practical <= ACCURATE,
        f"error at 0.9975 T_p, p1/p2 = 3/5 and m1/m2 = 9/7: {spread(t.practical for t in above)} km from above, "
        f"{spread(t.practical for t in below)} km from below",
    )


def _errors(trials: Sequence[Trial]) -> str:
    best, last = spread(t.best for t in trials), spread(t.last for t in trials)
    return f"error falls to {best} km and ends at {last} km"


def _well_before(runs: Sequence[Measurement], start: str) -> Verdict:
    late = sum(run.settling_time > WELL_BEFORE for run in runs)
    return on_graphs(
        f"Convergence typically occurs well before T_p (by 0.9 T_p, starts {start} x*).",
        runs,
        lambda run: run.settling_time <= WELL_BEFORE,
        f"settled to 1e-9 at t = {spread((run.settling_time for run in runs), '.6g')}; {late} of {len(runs)} runs "
        f"later than {WELL_BEFORE:g}",
    )
