"""Section (comparison), one run at a time: the laws and starts that it compares, and what is measured on a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner import gabf
from planner.base.arrays import Floats
from planner.reproduce.random_graphs import START, RandomGraph

T_P = 4.0
"""The prescribed time of section (comparison), s."""

H = (1.0, 2.0, 4.0, 8.0)
P = ((3, 5), (5, 7), (7, 9), (9, 11))
M = ((9, 7), (11, 7), (13, 7), (15, 7))
NODE = 99
"""The node that the paper plots, numbered from 1."""

# steps of 0.5 % in tau: places the settling time within 1 %, where neighbouring exponents differ by 5 % and more
SOLVER = gabf.Splitting(tolerance=0.005)


@dataclass(frozen=True)
class LawCase:
    """One law with its parameters and its start: "above" x* at 10 km everywhere, or "below" it at 0 km."""

    law: gabf.PrescribedTime | gabf.SingularityFree
    start: str

    @property
    def x0(self) -> float:
        return START if self.start == "above" else 0.0

    @property
    def group(self) -> str:
        """Law and start: what is compared with each other."""
        return f"{self.law.name}, {self.start}"

    @property
    def parameters(self) -> dict[str, float | str]:
        """The parameter values that tell cases of one group apart."""
        if isinstance(self.law, gabf.PrescribedTime):
            return {"h": self.law.h}
        return {"p1/p2": "{}/{}".format(*self.law.p), "m1/m2": "{}/{}".format(*self.law.m)}

    @property
    def label(self) -> str:
        return ", ".join(
            f"{name} = {value:g}" if name == "h" else f"{name} = {value}" for name, value in self.parameters.items()
        )


PRESCRIBED = tuple(LawCase(gabf.PrescribedTime(T=T_P, h=h, gamma=1.0), "above") for h in H)
FREE = tuple(
    LawCase(gabf.SingularityFree(T=T_P, h=1.0, gamma=10.0, eta=15.0, p=p, m=m), start)
    for start in ("above", "below")
    for p in P
    for m in M
)
CASES = PRESCRIBED + FREE


@dataclass(frozen=True)
class Measurement:
    """The results of one run of one case on one graph.

    ``settling_tau``, ``settling_time`` (s) and ``log10_remaining`` of :class:`planner.gabf.CostToGo`, +inf where it
    did not settle. ``largest_input``: the largest |u_i(t)| over all nodes and times, km/s; ``first_input`` at t = 0;
    ``last_input`` at the end of the run; ``typical_input`` the median over nodes of each node's own largest,
    ``node_input`` that of the node which the paper plots.
    ``energy``: the sum over nodes of the integral of u_i^2 dt, km^2/s. ``error``: max_i |x_i - x_i*| / max(1, x_i*) at
    the end against the oracle. ``within_bounds``: every certificate that applies holds, the printed T_* aside.
    """

    graph: int
    case: LawCase
    settling_tau: float
    settling_time: float
    log10_remaining: float
    largest_input: float
    first_input: float
    last_input: float
    typical_input: float
    node_input: float
    energy: float
    error: float
    within_bounds: bool

    @property
    def settled(self) -> bool:
        return bool(np.isfinite(self.settling_tau))

    @property
    def bounded(self) -> bool:
        """The input is finite throughout and has come down to 0 (1e-9 of its largest value) at the end."""
        return bool(np.isfinite(self.largest_input)) and self.last_input <= 1e-9 * self.largest_input


@dataclass(frozen=True, eq=False)
class Trace:
    """One node's run: ``t`` (k,) s, ``error`` x - x* (k,) km, ``u`` (k,) km/s."""

    case: LawCase
    node: int
    t: Floats
    error: Floats
    u: Floats


def run_case(
    graph: RandomGraph, optimum: gabf.Structure, index: int, case: LawCase
) -> tuple[Measurement, gabf.FieldHistory]:
    """Run ``case`` on the graph of number ``index``, whose ``optimum`` the certificates use, and keep every step."""
    result = gabf.solve(graph.network, law=case.law, x0=case.x0, solver=SOLVER, save=gabf.EverySteps())
    assert result.history is not None
    return _measure(graph, optimum, index, case, result, result.history), result.history


def plotted_node(graph: RandomGraph) -> int:
    """Array index of the paper's node 99, or the last node of a smaller graph; not the source."""
    k = min(NODE, graph.network.n_nodes) - 1
    return k - 1 if k == graph.source else k


def trace(graph: RandomGraph, case: LawCase, history: gabf.FieldHistory) -> Trace:
    """The run as the plotted node lives it."""
    k = plotted_node(graph)
    return Trace(case, k + 1, history.t, history.x[:, k] - graph.x_star[k], history.u[:, k])


def _measure(
    graph: RandomGraph,
    optimum: gabf.Structure,
    index: int,
    case: LawCase,
    result: gabf.CostToGo,
    history: gabf.FieldHistory,
) -> Measurement:
    certificates = gabf.certify(graph.network, case.law, result, optimum)
    peaks = np.abs(history.u).max(axis=0)
    return Measurement(
        graph=index,
        case=case,
        settling_tau=_or_infinite(result.settling_tau),
        settling_time=_or_infinite(result.settling_time),
        log10_remaining=_or_infinite(result.log10_remaining),
        largest_input=float(peaks.max()),
        first_input=float(np.abs(history.u[0]).max()),
        last_input=float(np.abs(history.u[-1]).max()),
        typical_input=float(np.median(np.delete(peaks, graph.network.sources))),
        node_input=float(peaks[plotted_node(graph)]),
        energy=_energy(history),
        error=gabf.max_error(result, graph.x_star),
        within_bounds=all(c.holds for c in certificates if "printed" not in c.name),
    )


def _energy(history: gabf.FieldHistory) -> float:
    """The integral of u^2 dt is that of u dx, which needs no time, where near T_p a double holds none."""
    return float((0.5 * (history.u[1:] + history.u[:-1]) * np.diff(history.x, axis=0)).sum())


def _or_infinite(value: float | None) -> float:
    return np.inf if value is None else value
