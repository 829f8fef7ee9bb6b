"""Section (comparison) sentence by sentence: confirmed or not, on how many graphs, by what numbers."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from operator import attrgetter

import numpy as np

from planner.reproduce.laws.cases import NODE, STARTS, T_P, Measurement, on_graphs, per_graph
from planner.reproduce.random_graphs import START
from planner.reproduce.report import Verdict, spread, tally

_FINEST = float(np.log10(np.spacing(T_P) / 2))

GROWTH = 10.0
"""How many times its size at t = 0 an input may reach before "bounded" is true in words only (ours)."""


Pair = tuple[Measurement, Measurement]
Quantity = Callable[[Measurement], float]

_TIME: Quantity = attrgetter("settling_time")
_TAU: Quantity = attrgetter("settling_tau")

EFFORTS: dict[str, Quantity] = {
    f"largest input of node {NODE}": lambda run: run.node_input,
    "largest input of any node": lambda run: run.largest_input,
    "largest input of the median node": lambda run: run.typical_input,
    "energy, the sum over nodes of the integral of u^2": lambda run: run.energy,
}
"""Readings of "control effort": the first is what the paper plots."""


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
    elsewhere = sum(graph.random_source < START for graph in graphs)
    overestimate = tally(
        "The initial conditions x_i(0) = 10 for all i in V\\S yield overestimated initial states.",
        (graph.largest_x_star < START for graph in graphs),
        f"largest x* {spread(graph.largest_x_star for graph in graphs)} km, the source being the node nearest the "
        f"middle of the square; {sum(graph.redraws for graph in graphs)} graphs were thrown away, "
        f"{sum(graph.cut_off for graph in graphs)} of them for a node without a path; from a source drawn at random x* "
        f"would stay below {START:g} on {elsewhere} of {len(graphs)}",
    )
    certificates = on_graphs(
        "(ours) Every bound of the paper that applies to a run holds on it, T_* as printed left aside.",
        runs,
        lambda run: run.within_bounds,
        f"{sum(run.within_bounds for run in runs)} of {len(runs)} runs",
    )
    free = [run for run in runs if run.case.law.name == "singularity-free"]
    return (
        overestimate,
        *_first_law([run for run in runs if run.case.law.name == "prescribed-time"]),
        *(found for start in STARTS for found in _free_law([run for run in free if run.case.start == start], start)),
        certificates,
    )


def _first_law(runs: Sequence[Measurement]) -> Iterator[Verdict]:
    where = "(prescribed-time law)"
    times = {h: [run.settling_time for run in runs if run.case.parameters["h"] == h] for h in (1, 8)}
    yield on_graphs(
        f"All state errors converge within the prescribed time T_p = {T_P:g} {where}.",
        runs,
        lambda run: run.settled and run.settling_time < T_P,
        "to 1e-9 at t = "
        + ", ".join(f"{spread(of_h, '.5f')} for h = {h}" for h, of_h in times.items())
        + "; to 0 at T_p only",
    )
    yield on_graphs(
        f"All the control inputs remain bounded {where}.",
        runs,
        lambda run: run.bounded and run.within_bounds,
        f"largest input {spread(run.largest_input for run in runs)} km/s, within eqs. (lowerli) and (ute) in every "
        "state, and 0 at T_p",
    )
    yield faster(f"Larger h leads to faster convergence {where}.", runs, "h", smaller=False)
    yield from costlier(f"... as the control effort increases {where}", runs, "h", smaller=False)


def _free_law(runs: Sequence[Measurement], start: str) -> Iterator[Verdict]:
    where = f"(singularity-free law, starts {start} x*)"
    late = sum(run.log10_remaining < _FINEST for run in runs)
    yield on_graphs(
        f"The state error converges before the prescribed time T_p = {T_P:g} {where}.",
        runs,
        lambda run: run.settled and run.error == 0.0,
        f"settling tau {spread(run.settling_tau for run in runs)}, t {spread((r.settling_time for r in runs), '.6g')}, "
        f"log10(T_p - t) {spread(run.log10_remaining for run in runs)}; closer to T_p than a double holds in "
        f"{late} of {len(runs)} runs; then x is the oracle's to the last bit",
    )
    yield on_graphs(
        f"All the control inputs remain bounded {where}.",
        runs,
        lambda run: run.bounded,
        f"largest input {spread(run.largest_input for run in runs)} km/s; finite as the law settles while its gain is"
        " so",
    )
    yield on_graphs(
        f"(ours) No input grows beyond {GROWTH:g} times the largest one at t = 0 {where}.",
        runs,
        lambda run: run.largest_input <= GROWTH * run.first_input,
        f"largest input over the largest at t = 0: {spread(run.largest_input / run.first_input for run in runs)}",
    )
    for name in ("p1/p2", "m1/m2"):
        yield faster(f"Smaller {name} yields faster convergence {where}.", runs, name, smaller=True)
        yield from costlier(
            f"... at the cost of increased control effort, smaller {name} {where}", runs, name, smaller=True
        )


def neighbours(runs: Sequence[Measurement], parameter: str) -> list[Pair]:
    """Pairs of runs of one graph whose ``parameter`` takes neighbouring values, smaller first, all else equal."""

    def rest(run: Measurement) -> tuple:
        others = sorted((name, str(value)) for name, value in run.case.parameters.items() if name != parameter)
        return run.graph, run.case.group, others

    ordered = sorted(runs, key=lambda run: (rest(run), Fraction(run.case.parameters[parameter])))
    return [(a, b) for a, b in itertools.pairwise(ordered) if rest(a) == rest(b)]


def faster(sentence: str, runs: Sequence[Measurement], parameter: str, smaller: bool) -> Verdict:
    """That the ``smaller`` (or else the larger) of two neighbouring values settles at an earlier t.

    Compared in tau where both laws share a clock, as t rounds to T_p; in t for the parameter h of the clock itself.
    Held on a graph if it does in all its pairs.
    """
    name, quantity = ("t", _TIME) if parameter == "h" else ("tau", _TAU)
    return _ordered(sentence, runs, parameter, quantity, smaller, f"settling {name}: ", attrgetter("settled"))


def costlier(sentence: str, runs: Sequence[Measurement], parameter: str, smaller: bool) -> list[Verdict]:
    """That the ``smaller`` (or else the larger) of two neighbours takes more effort: one verdict per reading."""
    return [_ordered(f"{sentence} ({name})", runs, parameter, effort, not smaller) for name, effort in EFFORTS.items()]


def _ordered(
    sentence: str,
    runs: Sequence[Measurement],
    parameter: str,
    quantity: Quantity,
    growing: bool,
    about: str = "",
    usable: Callable[[Measurement], bool] = lambda run: True,
) -> Verdict:
    """That a quantity grows (or else falls) with the parameter in all neighbouring pairs of a graph, all ``usable``.

    The note says in how many pairs it does, and by what factor.
    """
    sign, pairs = 1.0 if growing else -1.0, neighbours(runs, parameter)

    def as_said(pair: Pair) -> bool:
        return sign * quantity(pair[0]) < sign * quantity(pair[1])

    ratios = spread((quantity(b) / quantity(a) for a, b in pairs), ".4g")
    return tally(
        sentence,
        (
            all(as_said(pair) and all(map(usable, pair)) for pair in neighbours(graph, parameter))
            for graph in per_graph(runs)
        ),
        f"{about}as said in {sum(map(as_said, pairs))} of {len(pairs)} neighbouring pairs, larger {parameter} over "
        f"smaller {ratios}",
    )
