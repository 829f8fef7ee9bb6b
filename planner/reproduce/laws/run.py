"""``planner reproduce laws``: section (comparison), both strategies on many random graphs, every sentence judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from planner import gabf
from planner.base.progress import QUIET, Progress
from planner.problem.request import SERIAL, WorkersRequest, require_seed
from planner.processes.parallel import collected
from planner.reproduce.laws.cases import CASES, STARTS, T_P, LawCase, Measurement, Trace, run_case
from planner.reproduce.laws.fixed_time_bound import EXTREME, ScalarTime, bound_verdicts, paper_times, scalar_time
from planner.reproduce.laws.near_deadline import ABOVE, Trial, remark_verdicts, run_trials
from planner.reproduce.laws.verdicts import GraphFacts, law_verdicts
from planner.reproduce.random_graphs import OUT_DEGREE, START, RandomGraph, draw_graph
from planner.reproduce.report import Picture, Report, Row, require_counts, require_figures
from planner.reproduce.textbook import SolverRun

_MEASURES = ("settling_time", "settling_tau", "log10_remaining", "largest_input", "typical_input", "energy")
_WITH_LARGEST = ("settling_time", "largest_input")
_HISTORIES = (
    ("prescribed_time", "prescribed-time", "above"),
    ("singularity_free_above", "singularity-free", "above"),
    ("singularity_free_below", "singularity-free", "below"),
)


@dataclass(frozen=True, eq=False)
class LawStudy:
    """Everything measured on a graph; ``traces`` and ``solver_runs``, for the figures, on the first one only."""

    facts: GraphFacts
    runs: list[Measurement] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)
    traces: list[Trace] = field(default_factory=list)
    solver_runs: list[tuple[Trial, SolverRun]] = field(default_factory=list)


def run_laws(
    graphs: int = 20,
    nodes: int = 500,
    seed: int = 0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Report:
    """Section (comparison) on ``graphs`` random graphs of ``nodes`` nodes, remark (implementation) and eq. (fixtime).

    Graph k of a seed is the same however many are drawn. ``progress`` is called with ("graphs", done, total); once
    stopped the report comes back over the graphs that are whole, with ``complete`` False. Raises OptionError for
    fewer than one graph, too few nodes or a seed out of range, FileError where matplotlib is missing.
    """
    require_counts(graphs=graphs)
    require_seed(seed)
    require_figures()
    studies = collected(range(graphs), partial(_study_graph, nodes=nodes, seed=seed), workers, "graphs", progress)
    config = {"graphs": graphs, "nodes": nodes, "seed": seed, "out_degree": OUT_DEGREE, "start_km": START, "T_p_s": T_P}
    return law_report(studies, config, complete=len(studies) == graphs)


def law_report(studies: Sequence[LawStudy], config: dict[str, Any], complete: bool = True) -> Report:
    """Table, verdicts and figures of what was measured."""
    facts = [study.facts for study in studies]
    runs, trials = ([item for study in studies for item in of(study)] for of in (lambda s: s.runs, lambda s: s.trials))
    scalars, extreme = paper_times(), scalar_time(*EXTREME)
    return Report(
        name="laws",
        config=config,
        table=tuple(law_table(runs)),
        verdicts=(*law_verdicts(facts, runs), *remark_verdicts(trials, runs), *bound_verdicts(scalars, extreme)),
        figures=next((law_pictures(runs, s.traces, s.solver_runs, scalars) for s in studies if s.traces), {}),
        more={
            "fixed_time": [_scalar_row(scalar) for scalar in (*scalars, extreme)],
            "graphs": [asdict(each) for each in facts],
            "trials": [_flat(trial) for trial in trials],
            "runs": [_flat(run) for run in runs],
        },
        complete=complete,
    )


def law_table(runs: Sequence[Measurement]) -> list[Row]:
    """One line a law, start and parameters: medians over the graphs, and the ends of the ranges; s, km/s."""
    of_cases = [(case, [run for run in runs if run.case == case]) for case in CASES]
    return [{**_about(case), **_medians(of_case)} for case, of_case in of_cases if of_case]


def law_pictures(
    runs: Sequence[Measurement],
    traces: Sequence[Trace],
    solver_runs: Sequence[tuple[Trial, SolverRun]],
    scalars: Sequence[ScalarTime],
) -> dict[str, Picture]:
    """Every figure by its file name; that of the methods near T_p only if there are ``solver_runs``."""
    from planner.figures import laws as draw

    figures: dict[str, Picture] = {}
    for name, law, start in _HISTORIES:
        shown = [trace for trace in traces if trace.case.law.name == law and trace.case.start == start]
        figures[f"laws_{name}.png"] = draw.node_histories(_history_rows(shown), shown[0].node, T_P)
    grids: dict[str, dict[tuple[str, str], list[tuple[float, float]]]] = {start: {} for start in STARTS}
    for run in runs:
        if isinstance(run.case.law, gabf.SingularityFree):
            p, m = map(str, run.case.parameters.values())
            grids[run.case.start].setdefault((p, m), []).append((run.settling_tau, run.largest_input))
    figures["laws_exponents.png"] = draw.exponent_summary(grids)
    bounds = {name: [getattr(s, name) for s in scalars] for name in ("printed", "corrected", "sharp", "measured")}
    figures["laws_fixed_time_bound.png"] = draw.fixed_time_bounds([s.label for s in scalars], bounds)
    if solver_runs:
        above = [(trial.name.replace("T_p", "$T_p$"), run) for trial, run in solver_runs if trial.case == ABOVE]
        title = f"singularity-free law, {ABOVE.label}, start above $x^*$"
        figures["laws_near_deadline.png"] = draw.near_deadline({name: (r.t, r.error) for name, r in above}, T_P, title)
    return figures


def _history_rows(traces: Sequence[Trace]) -> list[tuple[str, dict[str, Any]]]:
    """A row of panels for each parameter at its first value, its curves by the other one; one row where there is one.

    Each with its title, and (t, error, u) by the label of the curve.
    """
    first, rows = traces[0].case.parameters, []
    for fixed in reversed(first) if len(first) > 1 else [""]:
        alike = [trace for trace in traces if trace.case.parameters.get(fixed) == first.get(fixed)]
        curves = {trace.case.without(fixed): (trace.t, trace.error, trace.u) for trace in alike}
        rows.append((f"{fixed} = {first[fixed]}" if fixed else "", curves))
    return rows


def _study_graph(k: int, progress: Progress, nodes: int, seed: int) -> LawStudy | None:
    """Graph k, measured whole, or None where it was interrupted."""
    rng = np.random.default_rng([seed, k])
    graph = draw_graph(rng, nodes)
    optimum = gabf.structure(graph.network, graph.x_star)
    study = LawStudy(_facts(graph, optimum, rng))
    for case in CASES:
        if progress.stopped:
            return None
        run, trace = run_case(graph, optimum, k, case)
        study.runs.append(run)
        study.traces.extend([trace] if k == 0 else [])
    for trial, solver_run in run_trials(graph, k):
        if progress.stopped:
            return None
        study.trials.append(trial)
        study.solver_runs.extend([(trial, solver_run)] if k == 0 else [])
    return study


def _facts(graph: RandomGraph, optimum: gabf.Structure, rng: np.random.Generator) -> GraphFacts:
    network = graph.network
    elsewhere = replace(network, sources=rng.integers(0, network.n_nodes, 1))
    return GraphFacts(
        nodes=network.n_nodes,
        out_degree=graph.out_degree,
        largest_x_star=float(graph.x_star.max()),
        diameter=optimum.diameter,
        redraws=graph.redraws,
        cut_off=graph.cut_off,
        random_source=float(gabf.oracle(elsewhere).max()),
    )


def _about(case: LawCase) -> Row:
    """A case spelled out."""
    return {"law": case.law.name, "start": case.start, **dict.fromkeys(("h", "p1/p2", "m1/m2")), **case.parameters}


def _medians(runs: Sequence[Measurement]) -> Row:
    row: dict[str, float] = {"graphs": len(runs), "settled": sum(run.settled for run in runs)}
    for name in _MEASURES:
        values = [getattr(run, name) for run in runs]
        row |= {name: float(np.median(values))} | ({f"{name}_max": max(values)} if name in _WITH_LARGEST else {})
    return row


def _flat(item: Measurement | Trial) -> Row:
    """One measured line, its case spelled out."""
    return {**_about(item.case), **{name: value for name, value in vars(item).items() if name != "case"}}


def _scalar_row(scalar: ScalarTime) -> Row:
    p, m = scalar.label.split(", ")
    return {"p1/p2": p, "m1/m2": m, **{name: value for name, value in vars(scalar).items() if name != "label"}}
