"""Remark (implementation) on one graph: explicit and implicit methods in t, up to T_p and just before it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from planner import gabf
from planner.reproduce.laws.cases import T_P, LawCase
from planner.reproduce.random_graphs import RandomGraph
from planner.reproduce.textbook import Initial, SolverRun, backward_euler, forward_euler, runge_kutta

PRACTICAL_END = 0.9975 * T_P
"""Where a run with ode45 stops short of T_p, s."""

COARSE, FINE = 1_000, 20_000
"""Numbers of equal steps from 0 to T_p: 4 ms and 0.2 ms."""

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
