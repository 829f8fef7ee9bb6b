"""``python -m reproduce laws``: section (comparison), both strategies on many random graphs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from planner import gabf
from planner.base.progress import QUIET, Progress
from reproduce.figures import Figure, NodeHistory, exponent_summary, node_histories
from reproduce.laws.cases import CASES, STARTS, T_P, LawCase, Measurement, Trace, run_case
from reproduce.laws.claims import CLAIMS, FIRST, GraphStudy, Group
from reproduce.laws.graphs import OUT_DEGREE, START, draw_graph
from reproduce.report import Report, Row, collect, judge

_MEASURES = ("settling_time", "settling_tau", "log10_remaining", "largest_input", "typical_input", "energy")
_WITH_LARGEST = ("settling_time", "largest_input")
_FACTS = ("nodes", "out_degree", "diameter", "largest_x_star", "random_source", "redraws", "cut_off")


def run_laws(graphs: int = 20, nodes: int = 500, seed: int = 0, jobs: int = 1, progress: Progress = QUIET) -> Report:
    """Section (comparison) on ``graphs`` random graphs of ``nodes`` nodes.

    Graph k of a seed does not depend on ``graphs``. Once ``progress`` is stopped the report covers the complete graphs,
    and its ``complete`` is False. Raises OptionError for fewer than one graph or too few nodes.
    """
    studies = collect(partial(study_graph, nodes=nodes, seed=seed), graphs, jobs, "graphs", progress)
    config = {"graphs": graphs, "nodes": nodes, "seed": seed, "out_degree": OUT_DEGREE, "start_km": START, "T_p_s": T_P}
    return Report(
        name="laws",
        config=config,
        table=law_table(studies),
        verdicts=judge(CLAIMS, studies),
        figures=law_figures(studies) if studies else {},
        more={
            "graphs": [{name: getattr(study, name) for name in _FACTS} for study in studies],
            "runs": [{"graph": k, **_flat(run)} for k, study in enumerate(studies) for run in study.runs],
        },
        complete=len(studies) == graphs,
    )


def study_graph(k: int, nodes: int = 500, seed: int = 0) -> GraphStudy:
    """Graph k of a seed: every case on it."""
    rng = np.random.default_rng([seed, k])
    graph = draw_graph(rng, nodes)
    network, optimum = graph.network, gabf.structure(graph.network, graph.x_star)
    elsewhere = replace(network, sources=rng.integers(0, network.n_nodes, 1))
    runs, traces = zip(*(run_case(graph, optimum, case) for case in CASES), strict=True)
    return GraphStudy(
        nodes=network.n_nodes,
        out_degree=graph.out_degree,
        diameter=optimum.diameter,
        largest_x_star=float(graph.x_star.max()),
        random_source=float(gabf.oracle(elsewhere).max()),
        redraws=graph.redraws,
        cut_off=graph.cut_off,
        runs=runs,
        traces=traces if k == 0 else (),
    )


def law_table(studies: Sequence[GraphStudy]) -> tuple[Row, ...]:
    """A line per law, start and parameters: medians over the graphs, and the largest values; s, km/s."""
    by_case = zip(CASES, zip(*(study.runs for study in studies), strict=True), strict=False)
    return tuple({**_about(case), **_medians(runs)} for case, runs in by_case)


def law_figures(studies: Sequence[GraphStudy]) -> dict[str, Figure]:
    """Every figure by its file name; courses are those of the first graph."""
    figures: dict[str, Figure] = {}
    groups: dict[str, Group] = {"prescribed_time": FIRST}
    groups |= {f"singularity_free_{start}": ("singularity-free", start) for start in STARTS}
    for name, group in groups.items():
        shown = [trace for trace in studies[0].traces if trace.case.group == group]
        figures[f"laws_{name}.png"] = node_histories(history_rows(shown), shown[0].node, T_P)
    grids: dict[str, dict[tuple[str, str], list[tuple[float, float]]]] = {start: {} for start in STARTS}
    for run in (run for study in studies for run in study.runs if run.case.group != FIRST):
        p, m = map(str, run.case.parameters.values())
        grids[run.case.start].setdefault((p, m), []).append((run.settling_tau, run.largest_input))
    return figures | {"laws_exponents.png": exponent_summary(grids)}


def history_rows(traces: Sequence[Trace]) -> list[tuple[str, dict[str, NodeHistory]]]:
    """A row of panels per parameter at its first value, with its title; curves by the value of the other parameter."""
    first, rows = traces[0].case.parameters, []
    for fixed in reversed(first) if len(first) > 1 else [""]:
        alike = [trace for trace in traces if trace.case.parameters.get(fixed) == first.get(fixed)]
        curves = {trace.case.label(without=fixed): trace.history for trace in alike}
        rows.append((f"{fixed} = {first[fixed]}" if fixed else "", curves))
    return rows


def _about(case: LawCase) -> Row:
    """Law, start and parameters."""
    return {"law": case.law.name, "start": case.start, **dict.fromkeys(("h", "p1/p2", "m1/m2")), **case.parameters}


def _medians(runs: Sequence[Measurement]) -> Row:
    row: dict[str, float] = {"graphs": len(runs), "settled": sum(run.settled for run in runs)}
    for name in _MEASURES:
        values = [getattr(run, name) for run in runs]
        row |= {name: float(np.median(values))} | ({f"{name}_max": max(values)} if name in _WITH_LARGEST else {})
    return row


def _flat(run: Measurement) -> dict[str, Any]:
    return {**_about(run.case), **{name: value for name, value in vars(run).items() if name != "case"}}
