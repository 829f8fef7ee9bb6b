"""Runs side by side: the same graph and law, one parameter moved to its next value."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from fractions import Fraction

from planner.reproduce.laws.cases import NODE, Measurement
from planner.reproduce.report import Verdict, spread, tally

Pair = tuple[Measurement, Measurement]
Quantity = Callable[[Measurement], float]

EFFORTS: dict[str, Quantity] = {
    f"largest input of node {NODE}": lambda run: run.node_input,
    "largest input of any node": lambda run: run.largest_input,
    "largest input of the median node": lambda run: run.typical_input,
    "energy, the sum over nodes of the integral of u^2": lambda run: run.energy,
}
"""Readings of "control effort": the first is what the paper plots."""


def per_graph(runs: Sequence[Measurement]) -> list[list[Measurement]]:
    """The runs of each graph."""
    ordered = sorted(runs, key=lambda run: run.graph)
    return [list(of_one) for _, of_one in itertools.groupby(ordered, key=lambda run: run.graph)]


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
    name, quantity = ("t", _time) if parameter == "h" else ("tau", _tau)
    sign = 1.0 if smaller else -1.0

    def holds(pair: Pair) -> bool:
        return all(run.settled for run in pair) and sign * quantity(pair[0]) < sign * quantity(pair[1])

    return _in_all_pairs(
        sentence, runs, parameter, holds, f"settling {name}: {_by(runs, parameter, quantity, smaller)}"
    )


def costlier(sentence: str, runs: Sequence[Measurement], parameter: str, smaller: bool) -> list[Verdict]:
    """That the ``smaller`` (or else the larger) of two neighbours takes more effort: one verdict per reading."""
    return [_costlier(f"{sentence} ({name})", runs, parameter, smaller, effort) for name, effort in EFFORTS.items()]


def _costlier(sentence: str, runs: Sequence[Measurement], parameter: str, smaller: bool, effort: Quantity) -> Verdict:
    sign = -1.0 if smaller else 1.0

    def holds(pair: Pair) -> bool:
        return sign * effort(pair[0]) < sign * effort(pair[1])

    return _in_all_pairs(sentence, runs, parameter, holds, _by(runs, parameter, effort, growing=not smaller))


def _in_all_pairs(
    sentence: str, runs: Sequence[Measurement], parameter: str, holds: Callable[[Pair], bool], note: str
) -> Verdict:
    return tally(sentence, (all(map(holds, neighbours(graph, parameter))) for graph in per_graph(runs)), note)


def _by(runs: Sequence[Measurement], parameter: str, quantity: Quantity, growing: bool) -> str:
    """In how many neighbouring pairs ``quantity`` grows (or else falls) with the parameter, and by what factor."""
    pairs = neighbours(runs, parameter)
    sign = 1.0 if growing else -1.0
    held = sum(sign * quantity(a) < sign * quantity(b) for a, b in pairs)
    ratios = spread((quantity(b) / quantity(a) for a, b in pairs), ".4g")
    return f"as said in {held} of {len(pairs)} neighbouring pairs, larger {parameter} over smaller {ratios}"


def _time(run: Measurement) -> float:
    return run.settling_time


def _tau(run: Measurement) -> float:
    return run.settling_tau
