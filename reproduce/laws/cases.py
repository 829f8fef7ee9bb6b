"""Section (comparison), one run at a time: its laws and starts, and the measurements of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner import gabf
from reproduce.figures import NodeHistory
from reproduce.laws.graphs import START, RandomGraph
from reproduce.report import or_infinite

T_P = 4.0
"""The prescribed time of section (comparison), s."""

H = (1.0, 2.0, 4.0, 8.0)
P = ((3, 5), (5, 7), (7, 9), (9, 11))
M = ((9, 7), (11, 7), (13, 7), (15, 7))
STARTS = ("above", "below")
NODE = 99
"""The node that the paper plots, numbered from 1."""

# steps of 0.5 % in tau: settling times and inputs within 1 %, where neighbouring exponents differ by 5 % and more
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
    def group(self) -> tuple[str, str]:
        """Law and start; runs of one group are compared with each other."""
        return self.law.name, self.start

    @property
    def parameters(self) -> dict[str, float | str]:
        """The parameter values that distinguish the cases of one group."""
        if isinstance(self.law, gabf.PrescribedTime):
            return {"h": self.law.h}
        return {"p1/p2": "{}/{}".format(*self.law.p), "m1/m2": "{}/{}".format(*self.law.m)}

    def label(self, without: str = "") -> str:
        """The parameters but one."""
        texts = {name: f"{value:g}" if name == "h" else value for name, value in self.parameters.items()}
        return ", ".join(f"{name} = {value}" for name, value in texts.items() if name != without)


PRESCRIBED = tuple(LawCase(gabf.PrescribedTime(T=T_P, h=h, gamma=1.0), "above") for h in H)
FREE = tuple(
    LawCase(gabf.SingularityFree(T=T_P, h=1.0, gamma=10.0, eta=15.0, p=p, m=m), start)
    for start in STARTS
    for p in P
    for m in M
)
CASES = PRESCRIBED + FREE


@dataclass(frozen=True)
class Measurement:
    """One run of one case on one graph.

    ``settling_tau``, ``settling_time`` (s) and ``log10_remaining`` of :class:`planner.gabf.CostToGo`, +inf where it
    did not settle. ``largest_input``: the largest |u_i(t)| over all nodes and times, km/s; ``first_input`` at t = 0;
    ``last_input`` at the end of the run; ``typical_input``: the median over nodes of each node's largest;
    ``node_input``: that of the node that the paper plots.
    ``energy``: the sum over nodes of the integral of u_i^2 dt, km^2/s. ``error``: max_i |x_i - x_i*| / max(1, x_i*) at
    the end, by Dijkstra's x*. ``within_bounds``: every certificate that applies holds, except the printed T_*.
    """

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
        """The input is finite throughout and falls to 0 (1e-9 of its largest value) at the end."""
        return bool(np.isfinite(self.largest_input)) and self.last_input <= 1e-9 * self.largest_input


@dataclass(frozen=True, eq=False)
class Trace:
    """The course of a run at the paper's node 99, or at a neighbour where that is the source."""

    case: LawCase
    node: int
    history: NodeHistory


def run_case(graph: RandomGraph, optimum: gabf.Structure, case: LawCase) -> tuple[Measurement, Trace]:
    """Run ``case`` on a graph, whose ``optimum`` the certificates use."""
    result = gabf.solve(graph.network, law=case.law, x0=case.x0, solver=SOLVER, save_every=1)
    course = result.history
    assert course is not None
    certificates = gabf.certify(graph.network, case.law, result, optimum)
    peaks, plotted = np.abs(course.u).max(axis=0), min(NODE, graph.network.n_nodes) - 1
    plotted -= plotted == graph.source
    measured = Measurement(
        case=case,
        settling_tau=or_infinite(result.settling_tau),
        settling_time=or_infinite(result.settling_time),
        log10_remaining=or_infinite(result.log10_remaining),
        largest_input=float(peaks.max()),
        first_input=float(np.abs(course.u[0]).max()),
        last_input=float(np.abs(course.u[-1]).max()),
        typical_input=float(np.median(np.delete(peaks, graph.network.sources))),
        node_input=float(peaks[plotted]),
        energy=_energy(course),
        error=gabf.max_error(result, graph.x_star),
        within_bounds=all(c.holds for c in certificates if "printed" not in c.name),
    )
    error = course.x[:, plotted] - graph.x_star[plotted]
    return measured, Trace(case, plotted + 1, (course.t, error, course.u[:, plotted]))


def _energy(course: gabf.FieldHistory) -> float:
    """The integral of u^2 dt as that of u dx, because a double resolves no time near T_p."""
    return float((0.5 * (course.u[1:] + course.u[:-1]) * np.diff(course.x, axis=0)).sum())
