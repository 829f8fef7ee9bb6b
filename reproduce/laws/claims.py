"""The sentences of section (comparison), and their checks on one graph."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from operator import attrgetter

from reproduce.laws.cases import NODE, STARTS, T_P, Measurement, Trace
from reproduce.laws.graphs import START
from reproduce.report import Claim

Group = tuple[str, str]
Quantity = Callable[[Measurement], float]

FIRST: Group = ("prescribed-time", "above")

GROWTH = 10.0
"""An input that exceeds this many times its size at t = 0 is not bounded in our reading."""

WELL_BEFORE = 0.9 * T_P
"""Our reading of "well before T_p", s."""

EFFORTS: dict[str, Quantity] = {
    f"largest input of node {NODE}": attrgetter("node_input"),
    "largest input of any node": attrgetter("largest_input"),
    "largest input of the median node": attrgetter("typical_input"),
    "energy, the sum over nodes of the integral of u^2": attrgetter("energy"),
}
"""Readings of "control effort": the first is what the paper plots."""


@dataclass(frozen=True, eq=False)
class GraphStudy:
    """All runs on one graph; ``traces`` for the figures.

    ``largest_x_star`` km; ``random_source``: the same from a source drawn at random. ``redraws``: the graphs rejected
    before this one, ``cut_off`` of them because a node had no path.
    """

    nodes: int
    out_degree: float
    diameter: int
    largest_x_star: float
    random_source: float
    redraws: int
    cut_off: int
    runs: tuple[Measurement, ...]
    traces: tuple[Trace, ...] = ()

    def of(self, group: Group) -> list[Measurement]:
        """The runs of one law from one start."""
        return [run for run in self.runs if run.case.group == group]

    def pairs(self, group: Group, parameter: str) -> list[tuple[Measurement, Measurement]]:
        """Runs whose ``parameter`` takes neighbouring values, the smaller first, all other parameters equal."""

        def rest(run: Measurement) -> str:
            return run.case.label(without=parameter)

        ordered = sorted(self.of(group), key=lambda run: (rest(run), Fraction(run.case.parameters[parameter])))
        return [(a, b) for a, b in itertools.pairwise(ordered) if rest(a) == rest(b)]

    def is_ordered(self, group: Group, parameter: str, quantity: Quantity, growing: bool) -> bool:
        """Whether a quantity grows (or else falls) with the parameter in all neighbouring pairs, which all settle."""
        sign = 1.0 if growing else -1.0
        return all(
            a.settled and b.settled and sign * quantity(a) < sign * quantity(b) for a, b in self.pairs(group, parameter)
        )

    def ratios(self, group: Group, parameter: str, quantity: Quantity) -> list[float]:
        """A quantity at the larger value of the parameter over that at the smaller one."""
        return [quantity(b) / quantity(a) for a, b in self.pairs(group, parameter)]


def _of_runs(group: Group, quantity: Quantity) -> Callable[[GraphStudy], Iterable[float]]:
    return lambda graph: map(quantity, graph.of(group))


def _in_all(group: Group, holds: Callable[[Measurement], bool]) -> Callable[[GraphStudy], bool]:
    return lambda graph: all(map(holds, graph.of(group)))


def _order(sentence: str, group: Group, parameter: str, quantity: Quantity, growing: bool) -> Claim[GraphStudy]:
    return Claim(
        sentence,
        lambda graph: graph.is_ordered(group, parameter, quantity, growing),
        f"larger {parameter} over smaller: {{:.4g}}",
        (lambda graph: graph.ratios(group, parameter, quantity),),
    )


def _first_law() -> Iterator[Claim[GraphStudy]]:
    where = "(prescribed-time law)"
    yield Claim(
        f"All state errors converge within the prescribed time T_p = {T_P:g} {where}.",
        _in_all(FIRST, lambda run: run.settled and run.settling_time < T_P),
        "to 1e-9 at t = {:.5f} s; to 0 at T_p only",
        (_of_runs(FIRST, attrgetter("settling_time")),),
    )
    yield Claim(
        f"All the control inputs remain bounded {where}.",
        _in_all(FIRST, lambda run: run.bounded and run.within_bounds),
        "largest input {} km/s, within eqs. (lowerli) and (ute) in every state, and 0 at T_p",
        (_of_runs(FIRST, attrgetter("largest_input")),),
    )
    # in t: h is a parameter of the clock
    yield _order(f"Larger h leads to faster convergence {where}.", FIRST, "h", attrgetter("settling_time"), False)
    for name, effort in EFFORTS.items():
        yield _order(f"... as the control effort increases {where} ({name})", FIRST, "h", effort, True)


def _free_law(start: str) -> Iterator[Claim[GraphStudy]]:
    free, where = ("singularity-free", start), f"(singularity-free law, starts {start} x*)"
    yield Claim(
        f"The state error converges before the prescribed time T_p = {T_P:g} {where}.",
        _in_all(free, lambda run: run.settled and run.error == 0.0),
        "settling tau {}, t {:.6g} s, log10(T_p - t) {}; x is then Dijkstra's to the last bit",
        tuple(_of_runs(free, attrgetter(name)) for name in ("settling_tau", "settling_time", "log10_remaining")),
    )
    yield Claim(
        f"All the control inputs remain bounded {where}.",
        _in_all(free, lambda run: run.bounded),
        "largest input {} km/s",
        (_of_runs(free, attrgetter("largest_input")),),
    )
    yield Claim(
        f"(ours) No input grows beyond {GROWTH:g} times the largest one at t = 0 {where}.",
        _in_all(free, lambda run: run.largest_input <= GROWTH * run.first_input),
        "largest input over the largest at t = 0: {}",
        (_of_runs(free, lambda run: run.largest_input / run.first_input),),
    )
    for name in ("p1/p2", "m1/m2"):
        # in tau: t rounds to T_p
        yield _order(f"Smaller {name} yields faster convergence {where}.", free, name, attrgetter("settling_tau"), True)
        for reading, effort in EFFORTS.items():
            cost = f"... at the cost of increased control effort, smaller {name} {where} ({reading})"
            yield _order(cost, free, name, effort, False)
    yield Claim(
        f"Convergence typically occurs well before T_p (by 0.9 T_p, starts {start} x*).",
        _in_all(free, lambda run: run.settling_time <= WELL_BEFORE),
        "settled to 1e-9 at t = {:.6g} s",
        (_of_runs(free, attrgetter("settling_time")),),
    )


CLAIMS: tuple[Claim[GraphStudy], ...] = (
    Claim(
        "The initial conditions x_i(0) = 10 for all i in V\\S yield overestimated initial states.",
        lambda graph: graph.largest_x_star < START,
        "largest x* {} km from the source, the node nearest the middle of the square; {} km from a source drawn at "
        "random; {} graphs were rejected before each, {} of them for a node without a path",
        tuple(attrgetter(name) for name in ("largest_x_star", "random_source", "redraws", "cut_off")),
    ),
    *_first_law(),
    *(claim for start in STARTS for claim in _free_law(start)),
    Claim(
        "(ours) Every bound of the paper that applies to a run holds on it, except T_* as printed.",
        lambda graph: all(run.within_bounds for run in graph.runs),
    ),
)
