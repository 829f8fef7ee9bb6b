"""Section (comparison) sentence by sentence: confirmed or not, on how many graphs, by what numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.reproduce.laws.cases import T_P, Measurement
from planner.reproduce.laws.comparisons import costlier, faster, per_graph
from planner.reproduce.random_graphs import START
from planner.reproduce.report import Verdict, spread, tally

STARTS = ("above", "below")

_FINEST = float(np.log10(np.spacing(T_P) / 2))

GROWTH = 10.0
"""How many times its size at t = 0 an input may reach before "bounded" is true in words only (ours)."""


@dataclass(frozen=True)
class GraphFacts:
    """One graph in numbers: nodes, mean out-degree, the largest x_i* (km), and D(G) as ``diameter``.

    ``redraws``: the graphs rejected before it; ``cut_off``: how many of them had a node without a path.
    ``random_source``: the largest x_i* from a source drawn at random.
    """

    nodes: int
    out_degree: float
    largest_x_star: float
    diameter: int
    redraws: int
    cut_off: int
    random_source: float


def law_verdicts(graphs: Sequence[GraphFacts], runs: Sequence[Measurement]) -> tuple[Verdict, ...]:
    """Every sentence of section (comparison) about the two strategies; counts are of graphs."""
    found = [_overestimate(graphs), *_first_law([run for run in runs if run.case.law.name == "prescribed-time"])]
    free = [run for run in runs if run.case.law.name == "singularity-free"]
    for start in STARTS:
        found += _free_law([run for run in free if run.case.start == start], start)
    return (*found, _certificates(runs))


def _overestimate(graphs: Sequence[GraphFacts]) -> Verdict:
    elsewhere = sum(graph.random_source < START for graph in graphs)
    return tally(
        "The initial conditions x_i(0) = 10 for all i in V\\S yield overestimated initial states.",
        (graph.largest_x_star < START for graph in graphs),
        f"largest x* {spread(graph.largest_x_star for graph in graphs)} km, the source being the node nearest the "
        f"middle of the square; {sum(graph.redraws for graph in graphs)} graphs were thrown away, "
        f"{sum(graph.cut_off for graph in graphs)} of them for a node without a path; from a source drawn at random x* "
        f"would stay below {START:g} on {elsewhere} of {len(graphs)}",
    )


def _first_law(runs: Sequence[Measurement]) -> list[Verdict]:
    where = "(prescribed-time law)"
    return [
        tally(
            f"All state errors converge within the prescribed time T_p = {T_P:g} {where}.",
            (all(run.settled and run.settling_time < T_P for run in graph) for graph in per_graph(runs)),
            "to 1e-9 at t = " + ", ".join(f"{_times(runs, h)} for h = {h}" for h in (1, 8)) + "; to 0 at T_p only",
        ),
        tally(
            f"All the control inputs remain bounded {where}.",
            (all(run.bounded and run.within_bounds for run in graph) for graph in per_graph(runs)),
            f"largest input {spread(run.largest_input for run in runs)} km/s, within eqs. (lowerli) and (ute) in every "
            "state, and 0 at T_p",
        ),
        faster(f"Larger h leads to faster convergence {where}.", runs, "h", smaller=False),
        *costlier(f"... as the control effort increases {where}", runs, "h", smaller=False),
    ]


def _times(runs: Sequence[Measurement], h: float) -> str:
    return spread((run.settling_time for run in runs if run.case.parameters["h"] == h), ".5f")


def _free_law(runs: Sequence[Measurement], start: str) -> list[Verdict]:
    where = f"(singularity-free law, starts {start} x*)"
    found = [_converges(runs, where), _bounded(runs, where), _no_growth(runs, where)]
    for name in ("p1/p2", "m1/m2"):
        found.append(faster(f"Smaller {name} yields faster convergence {where}.", runs, name, smaller=True))
        found += costlier(
            f"... at the cost of increased control effort, smaller {name} {where}", runs, name, smaller=True
        )
    return found


def _converges(runs: Sequence[Measurement], where: str) -> Verdict:
    late = sum(run.log10_remaining < _FINEST for run in runs)
    return tally(
        f"The state error converges before the prescribed time T_p = {T_P:g} {where}.",
        (all(run.settled and run.error == 0.0 for run in graph) for graph in per_graph(runs)),
        f"settling tau {spread(run.settling_tau for run in runs)}, t {spread((r.settling_time for r in runs), '.6g')}, "
        f"log10(T_p - t) {spread(run.log10_remaining for run in runs)}; closer to T_p than a double holds in "
        f"{late} of {len(runs)} runs; then x is the oracle's to the last bit",
    )


def _bounded(runs: Sequence[Measurement], where: str) -> Verdict:
    return tally(
        f"All the control inputs remain bounded {where}.",
        (all(run.bounded for run in graph) for graph in per_graph(runs)),
        f"largest input {spread(run.largest_input for run in runs)} km/s; finite as the law settles while its gain is"
        " so",
    )


def _no_growth(runs: Sequence[Measurement], where: str) -> Verdict:
    return tally(
        f"(ours) No input grows beyond {GROWTH:g} times the largest one at t = 0 {where}.",
        (all(run.largest_input <= GROWTH * run.first_input for run in graph) for graph in per_graph(runs)),
        f"largest input over the largest at t = 0: {spread(run.largest_input / run.first_input for run in runs)}",
    )


def _certificates(runs: Sequence[Measurement]) -> Verdict:
    return tally(
        "(ours) Every bound of the paper that applies to a run holds on it, T_* as printed left aside.",
        (all(run.within_bounds for run in graph) for graph in per_graph(runs)),
        f"{sum(run.within_bounds for run in runs)} of {len(runs)} runs",
    )
