"""The figures of section (comparison), from what was measured: which runs go into which picture."""

from __future__ import annotations

from collections.abc import Sequence

from planner import gabf
from planner.figures import laws as law_figures
from planner.reproduce.laws.cases import T_P, M, Measurement, P, Trace
from planner.reproduce.laws.fixed_time_bound import ScalarTime
from planner.reproduce.laws.near_deadline import ABOVE, Trial
from planner.reproduce.report import Picture
from planner.reproduce.textbook import SolverRun


def law_pictures(
    runs: Sequence[Measurement],
    traces: Sequence[Trace],
    solver_runs: Sequence[tuple[Trial, SolverRun]],
    scalars: Sequence[ScalarTime],
) -> dict[str, Picture]:
    """Every figure by its file name; that of the methods near T_p only if there are ``solver_runs``."""
    figures = {
        "laws_prescribed_time.png": _node_figure(traces, "prescribed-time", "above"),
        "laws_singularity_free_above.png": _node_figure(traces, "singularity-free", "above"),
        "laws_singularity_free_below.png": _node_figure(traces, "singularity-free", "below"),
        "laws_exponents.png": law_figures.exponent_summary(_summary(runs)),
        "laws_fixed_time_bound.png": _bound_figure(scalars),
    }
    return figures | ({"laws_near_deadline.png": _deadline_figure(solver_runs)} if solver_runs else {})


def _node_figure(traces: Sequence[Trace], law: str, start: str) -> Picture:
    chosen = [trace for trace in traces if trace.case.law.name == law and trace.case.start == start]
    curves = {trace.case.label: (trace.t, trace.error, trace.u) for trace in chosen}
    if law == "prescribed-time":
        return law_figures.node_histories([("", curves)], chosen[0].node, T_P)
    rows = [
        (f"m1/m2 = {_text(M[0])}", _with(curves, f"m1/m2 = {_text(M[0])}")),
        (f"p1/p2 = {_text(P[0])}", _with(curves, f"p1/p2 = {_text(P[0])}")),
    ]
    return law_figures.node_histories(rows, chosen[0].node, T_P)


def _with(curves: dict[str, law_figures.NodeHistory], fixed: str) -> dict[str, law_figures.NodeHistory]:
    """The curves that share the parameter ``fixed``, labelled by the other one."""
    return {
        label.replace(fixed, "").strip(", "): curve for label, curve in curves.items() if fixed in label.split(", ")
    }


def _summary(runs: Sequence[Measurement]) -> dict[str, law_figures.Grid]:
    """For both starts, (settling tau, largest input) of every graph by (p1/p2, m1/m2)."""
    cells: dict[str, dict[tuple[str, str], list[tuple[float, float]]]] = {"above": {}, "below": {}}
    for run in runs:
        if isinstance(run.case.law, gabf.SingularityFree):
            key = _text(run.case.law.p), _text(run.case.law.m)
            cells[run.case.start].setdefault(key, []).append((run.settling_tau, run.largest_input))
    return dict(cells)


def _deadline_figure(solver_runs: Sequence[tuple[Trial, SolverRun]]) -> Picture:
    shown = {
        trial.name.replace("T_p", "$T_p$"): (run.t, run.error) for trial, run in solver_runs if trial.case == ABOVE
    }
    return law_figures.near_deadline(shown, T_P, f"singularity-free law, {ABOVE.label}, start above $x^*$")


def _bound_figure(scalars: Sequence[ScalarTime]) -> Picture:
    lines = {name: [getattr(s, name) for s in scalars] for name in ("printed", "corrected", "sharp", "measured")}
    return law_figures.fixed_time_bounds([s.label for s in scalars], lines)


def _text(pair: tuple[int, int]) -> str:
    return "{}/{}".format(*pair)
