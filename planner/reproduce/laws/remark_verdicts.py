"""Remark (implementation) and eq. (fixtime): confirmed or not, by what numbers."""

from __future__ import annotations

from collections.abc import Sequence

from planner.reproduce.laws.cases import T_P, LawCase, Measurement
from planner.reproduce.laws.comparisons import per_graph
from planner.reproduce.laws.fixed_time_bound import ScalarTime
from planner.reproduce.laws.near_deadline import ABOVE, BELOW, FIRST, Trial
from planner.reproduce.report import Verdict, spread, tally

WELL_BEFORE = 0.9 * T_P
"""What "well before T_p" is taken to mean, s."""

ACCURATE = 1e-3
"""The error that a run in practice may have, km: a metre in ten kilometres."""


def remark_verdicts(trials: Sequence[Trial], runs: Sequence[Measurement]) -> tuple[Verdict, ...]:
    """The sentences of remark (implementation); counts are of graphs."""
    free = [run for run in runs if run.case.law.name == "singularity-free"]
    early = [_well_before([run for run in free if run.case.start == start], start) for start in ("above", "below")]
    return (_explicit_fails(trials), _implicit_preferred(trials), _practical(trials), *early)


def bound_verdicts(scalars: Sequence[ScalarTime], extreme: ScalarTime) -> tuple[Verdict, ...]:
    """Eq. (fixtime): T_* as printed, corrected and sharp against one node from afar; counts are of exponent pairs."""
    failing = [f"{s.label}: {s.printed:.4g} < {s.measured:.4g}" for s in scalars if s.printed < s.measured]
    where = "; p1/p2, m1/m2 where it is none: " + "; ".join(failing) if failing else ""
    return (
        tally(
            "T_* of eq. (fixtime), as printed, bounds the settling time of one node from any start.",
            (s.measured <= s.printed for s in scalars),
            f"printed over measured tau {spread(s.printed / s.measured for s in scalars)}{where}",
        ),
        tally(
            "x_i(t) = x_i* for t >= 2|V\\S|T_* + |V\\S|max{0, T_f} (T_* as printed, p1/p2 = 1/9, m1/m2 = 5).",
            [extreme.measured <= extreme.theorem],
            f"one node from afar: promised by tau = {extreme.theorem:.4g}, settled at {extreme.measured:.4g}",
        ),
        tally(
            "(ours) T_* corrected, m2/(beta2 (m1 - m2)) + p2/(beta1 (p2 - p1)), is a bound.",
            (s.measured <= s.corrected for s in (*scalars, extreme)),
            f"corrected over measured tau {spread(s.corrected / s.measured for s in (*scalars, extreme))}",
        ),
        tally(
            "(ours) T_* sharp, the integral from 0 to infinity, is a bound and is met.",
            (0.999 * s.sharp <= s.measured <= s.sharp for s in (*scalars, extreme)),
            f"measured over sharp {spread((s.measured / s.sharp for s in (*scalars, extreme)), '.6f')}",
        ),
    )


def _select(trials: Sequence[Trial], case: LawCase, method: str) -> list[Trial]:
    """The trials of one case whose name begins with ``method``, graph by graph."""
    return [trial for trial in trials if trial.case == case and trial.name.startswith(method)]


def _by_graph(trials: Sequence[Trial]) -> list[list[Trial]]:
    return [[trial for trial in trials if trial.graph == k] for k in sorted({trial.graph for trial in trials})]


def _explicit_fails(trials: Sequence[Trial]) -> Verdict:
    """Failing: to end far off x* after having been a hundred times closer, at every step size tried."""
    euler, first = _select(trials, ABOVE, "forward Euler"), _select(trials, FIRST, "forward Euler")
    notes = [f"{name}: {_errors([t for t in euler if t.name == name])}" for name in sorted({t.name for t in euler})]
    for case in (ABOVE, FIRST):
        rk = _select(trials, case, "RK45")
        notes.append(f"RK45 gives up before T_p in {sum(not t.reached for t in rk)} of {len(rk)} ({case.law.name} law)")
    return tally(
        "Explicit methods may fail near the prescribed time T_p even with very small time steps.",
        (all(t.last > max(ACCURATE, 100.0 * t.best) for t in graph) for graph in _by_graph(euler)),
        "; ".join(notes) + f"; under the prescribed-time law forward Euler does not fail: {_errors(first)}",
    )


def _implicit_preferred(trials: Sequence[Trial]) -> Verdict:
    """Preferred: accurate at T_p, in both laws, in steps with which the explicit method fails in the second."""
    names = {case.law.name: _select(trials, case, "backward Euler") for case in (ABOVE, FIRST)}
    both = _by_graph([trial for of_law in names.values() for trial in of_law])
    return tally(
        "Implicit methods, such as the backward Euler method, are generally preferred.",
        (all(trial.last <= ACCURATE for trial in graph) for graph in both),
        "; ".join(f"{law} law, {of_law[0].name}: {_errors(of_law)}" for law, of_law in names.items() if of_law),
    )


def _practical(trials: Sequence[Trial]) -> Verdict:
    """Practical: accurate where a run with ode45 stops, from both starts."""
    above, below = _select(trials, ABOVE, "RK45"), _select(trials, BELOW, "RK45")
    return tally(
        "Explicit solvers such as ode45 remain practical (SciPy's RK45, rtol 1e-6, stopped at 0.9975 T_p).",
        (all(trial.practical <= ACCURATE for trial in graph) for graph in _by_graph([*above, *below])),
        f"error at 0.9975 T_p, p1/p2 = 3/5 and m1/m2 = 9/7: {spread(t.practical for t in above)} km from above, "
        f"{spread(t.practical for t in below)} km from below",
    )


def _errors(trials: Sequence[Trial]) -> str:
    best, last = spread(t.best for t in trials), spread(t.last for t in trials)
    return f"error falls to {best} km and ends at {last} km"


def _well_before(runs: Sequence[Measurement], start: str) -> Verdict:
    late = sum(run.settling_time > WELL_BEFORE for run in runs)
    return tally(
        f"Convergence typically occurs well before T_p (by 0.9 T_p, starts {start} x*).",
        (all(run.settling_time <= WELL_BEFORE for run in graph) for graph in per_graph(runs)),
        f"settled to 1e-9 at t = {spread((run.settling_time for run in runs), '.6g')}; {late} of {len(runs)} runs "
        f"later than {WELL_BEFORE:g}",
    )
