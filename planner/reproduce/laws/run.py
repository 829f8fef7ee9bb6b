"""``planner reproduce laws``: section (comparison), both strategies on many random graphs, every sentence judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from planner import gabf
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.problem.request import SERIAL, WorkersRequest, require_seed
from planner.processes.parallel import collected
from planner.reproduce.laws.cases import CASES, T_P, Measurement, Trace, run_case, trace
from planner.reproduce.laws.fixed_time_bound import ScalarTime, extreme_time, paper_times
from planner.reproduce.laws.near_deadline import Trial, run_trials
from planner.reproduce.laws.remark_verdicts import bound_verdicts, remark_verdicts
from planner.reproduce.laws.verdicts import GraphFacts, law_verdicts
from planner.reproduce.random_graphs import OUT_DEGREE, START, RandomGraph, draw_graph
from planner.reproduce.report import Picture, Report, Row, require_figures
from planner.reproduce.textbook import SolverRun


@dataclass(frozen=True, eq=False)
class LawStudy:
    """Everything measured, graph after graph; ``traces`` and ``solver_runs`` of the first graph, for the figures."""

    facts: list[GraphFacts] = field(default_factory=list)
    runs: list[Measurement] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)
    traces: list[Trace] = field(default_factory=list)
    solver_runs: list[tuple[Trial, SolverRun]] = field(default_factory=list)

    def extend(self, other: LawStudy) -> None:
        """Take in one more whole graph."""
        for name in ("facts", "runs", "trials", "traces", "solver_runs"):
            getattr(self, name).extend(getattr(other, name))


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
    if graphs < 1:
        raise OptionError(f"graphs must be at least 1, not {graphs}.")
    require_seed(seed)
    require_figures()
    study, on_graph = LawStudy(), partial(_study_graph, nodes=nodes, seed=seed)
    for done in collected(range(graphs), on_graph, workers, "graphs", progress):
        study.extend(done)
    config = {"graphs": graphs, "nodes": nodes, "seed": seed, "out_degree": OUT_DEGREE, "start_km": START, "T_p_s": T_P}
    return law_report(study, config, complete=len(study.facts) == graphs)


def law_report(study: LawStudy, config: dict[str, Any], complete: bool = True) -> Report:
    """Table, verdicts and figures of what was measured."""
    scalars, extreme = paper_times(), extreme_time()
    return Report(
        name="laws",
        config=config,
        table=tuple(law_table(study.runs)),
        verdicts=(
            *law_verdicts(study.facts, study.runs),
            *remark_verdicts(study.trials, study.runs),
            *bound_verdicts(scalars, extreme),
        ),
        figures=_figures(study, scalars) if study.traces else {},
        more={
            "fixed_time": [_scalar_row(scalar) for scalar in (*scalars, extreme)],
            "graphs": [asdict(facts) for facts in study.facts],
            "trials": [_flat(trial) for trial in study.trials],
            "runs": [_flat(run) for run in study.runs],
        },
        complete=complete,
    )


def law_table(runs: Sequence[Measurement]) -> list[Row]:
    """One line a law, start and parameters: medians over the graphs, and the ends of the ranges; s, km/s."""
    rows = []
    for case in CASES:
        of_case = [run for run in runs if run.case == case]
        if of_case:
            rows.append(
                {"law": case.law.name, "start": case.start, **_parameters(case.parameters), **_medians(of_case)}
            )
    return rows


def _study_graph(k: int, progress: Progress, nodes: int, seed: int) -> LawStudy | None:
    """Graph k, measured whole, or None where it was interrupted."""
    rng = np.random.default_rng([seed, k])
    graph = draw_graph(rng, nodes)
    optimum = gabf.structure(graph.network, graph.x_star)
    study = LawStudy(facts=[_facts(graph, optimum, rng)])
    for case in CASES:
        if progress.stopped:
            return None
        run, history = run_case(graph, optimum, k, case)
        study.runs.append(run)
        if k == 0:
            study.traces.append(trace(graph, case, history))
    for trial, solver_run in run_trials(graph, k):
        if progress.stopped:
            return None
        study.trials.append(trial)
        if k == 0:
            study.solver_runs.append((trial, solver_run))
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


def _parameters(parameters: dict[str, Any]) -> Row:
    return {name: parameters.get(name) for name in ("h", "p1/p2", "m1/m2")}


def _medians(runs: Sequence[Measurement]) -> Row:
    inputs = [run.largest_input for run in runs]
    return {
        "graphs": len(runs),
        "settled": sum(run.settled for run in runs),
        "settling_time": _median(run.settling_time for run in runs),
        "settling_time_max": max(run.settling_time for run in runs),
        "settling_tau": _median(run.settling_tau for run in runs),
        "log10_remaining": _median(run.log10_remaining for run in runs),
        "largest_input": _median(inputs),
        "largest_input_max": max(inputs),
        "typical_input": _median(run.typical_input for run in runs),
        "energy": _median(run.energy for run in runs),
    }


def _median(values: Any) -> float:
    return float(np.median(list(values)))


def _flat(item: Measurement | Trial) -> Row:
    """One measured line, its case spelled out."""
    plain = {name: value for name, value in vars(item).items() if name != "case"}
    return {"law": item.case.law.name, "start": item.case.start, **_parameters(item.case.parameters), **plain}


def _scalar_row(scalar: ScalarTime) -> Row:
    names = ("printed", "corrected", "sharp", "measured")
    p, m = scalar.label.split(", ")
    return {"p1/p2": p, "m1/m2": m, **{name: getattr(scalar, name) for name in names}}


def _figures(study: LawStudy, scalars: Sequence[ScalarTime]) -> dict[str, Picture]:
    from planner.reproduce.laws.figures import law_pictures

    return law_pictures(study.runs, study.traces, study.solver_runs, scalars)
