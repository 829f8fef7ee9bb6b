"""``python -m reproduce example``: the nine-node graph of fig. (example1), and every sentence on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner import gabf
from planner.base.errors import AssumptionError
from reproduce.figures import nine_node_graph
from reproduce.report import Claim, Report, Row, judge

Nodes = tuple[int, ...]
"""Nodes in the paper's numbering, which starts at 1."""

BELOW = 1.0
"""The lowest start in the kernel's domain a >= 1; every x_i* of a non-source node is above it."""

_NINE_NODE_ARCS = [
    # node i reads node j over weight w, in the paper's numbering
    (2, 1, 1.0),
    (2, 5, 0.5),
    (3, 1, 1.0),
    (3, 4, -0.5),
    (4, 2, 1.0),
    (4, 3, 1.0),
    (4, 7, -2.0),
    (5, 2, 1.0),
    (5, 4, 2.0),
    (6, 8, 1.0),
    (6, 9, 5.0),
    (6, 5, 0.5),
    (7, 9, -1.5),
    (7, 8, 2.0),
    (8, 9, 1.0),
    (8, 6, 3.0),
]

RUNS: tuple[tuple[gabf.Law, str], ...] = (
    *((law, "above") for law in (gabf.Nominal(), gabf.PrescribedTime(), gabf.FixedTime(), gabf.SingularityFree())),
    *((law, "below") for law in (gabf.FixedTime(), gabf.SingularityFree())),
)


def nine_node() -> gabf.Network:
    """The example of fig. (example1), with weights of our own that agree with everything the text says of it.

    Array index k is node k + 1. Sources 1 and 9 with x* = 1; x_4* = 7 through 2 or 3, so P(4) = {2, 3}; 6
    reaches 9 both directly and through 8 at x_6* = 7, so 6 is in F_2 and not in F_1; D(G) = 3. Some weights
    are negative, as the kernels read |b|; the figure itself is not part of the paper's source.
    """
    i, j, w = (np.array(column) for column in zip(*_NINE_NODE_ARCS, strict=True))
    return gabf.Network.from_arcs(
        i.astype(np.int64) - 1,
        j.astype(np.int64) - 1,
        w,
        sources=np.array([0, 8]),
        n_nodes=9,
        source_values=np.ones(2),
        kernel=gabf.NodeDependent(),
    )


@dataclass(frozen=True, eq=False)
class Example:
    """A graph of nine nodes and the structure of its optimum, in the paper's numbering."""

    network: gabf.Network
    optimum: gabf.Structure

    @property
    def sources(self) -> Nodes:
        return _numbers(self.network.sources)

    def x(self, i: int) -> float:
        """x_i*."""
        return float(self.optimum.x_star[i - 1])

    def parents(self, i: int) -> Nodes:
        """P(i), definition (true)."""
        return _numbers(gabf.true_parents(self.network, self.optimum, i - 1))

    def paths(self, i: int) -> set[Nodes]:
        """Every optimal path from node i to a source, definition (longest)."""
        if i in self.sources:
            return {(i,)}
        return {(i, *rest) for j in self.parents(i) for rest in self.paths(j)}

    def F(self, level: int) -> Nodes:
        """F_l, definition (longest)."""
        return _numbers(np.flatnonzero(self.optimum.longest == level))


CLAIMS: tuple[Claim[Example], ...] = (
    Claim(
        "The graph consists of 9 nodes: 2 source nodes (nodes 1 and 9) and 7 non-source nodes.",
        lambda graph: graph.network.n_nodes == 9 and graph.sources == (1, 9),
    ),
    Claim("x_1* = x_9* = 1.", lambda graph: graph.x(1) == graph.x(9) == 1.0),
    Claim(
        "x_4* = 7 is achievable via paths 4 -> 2 -> 1 or 4 -> 3 -> 1.",
        lambda graph: graph.x(4) == 7.0 and {(4, 2, 1), (4, 3, 1)} <= graph.paths(4),
    ),
    Claim("P(4) = {2, 3}.", lambda graph: graph.parents(4) == (2, 3)),
    Claim(
        "D(G) = 3, indicated by paths like 6 -> 8 -> 9.",
        lambda graph: graph.optimum.diameter == 3 and (6, 8, 9) in graph.paths(6),
    ),
    Claim(
        "Node 6 has two optimal paths to its nearest source: 6 -> 8 -> 9 and 6 -> 9, both of which yield x_6* = 7.",
        lambda graph: graph.paths(6) == {(6, 8, 9), (6, 9)} and graph.x(6) == 7.0,
    ),
    Claim("6 is in F_2 but not in F_1.", lambda graph: 6 in graph.F(2) and 6 not in graph.F(1)),
    Claim(
        "F_0 = S, the union of all F_l is V, and no two of them meet.",
        lambda graph: (
            graph.F(0) == graph.sources
            and sorted(sum(map(graph.F, range(graph.optimum.diameter)), ())) == [*range(1, graph.network.n_nodes + 1)]
        ),
    ),
    Claim(
        "The overestimation assumption applies to the prescribed-time strategy: it is refused a start below x*.",
        lambda graph: _is_refused(graph.network, gabf.PrescribedTime(), BELOW),
    ),
)

RUN_CLAIMS: tuple[Claim[Row], ...] = (
    Claim(
        "The state of every node stabilises at x_i* under each law, from each start that its theorem allows.",
        lambda run: run["outcome"] == gabf.Ending.SETTLED.key and run["error"] <= 1e-12,
        "settled at t = {} s",
        (lambda run: run["settling_time"],),
    ),
    Claim(
        "(ours) Every bound of the paper that applies to a run holds on it, except T_* as printed.",
        lambda run: run["bounds_held"] == run["bounds"],
        "{} bounds per run",
        (lambda run: run["bounds"],),
    ),
)


def run_example(seed: int = 0) -> Report:
    """Check every sentence on the example, and solve it under every law from every start that the law allows.

    The weights are ours, as the paper's source lacks the figure: :func:`nine_node`. Nothing here
    is random; the report keeps ``seed``.
    """
    network = nine_node()
    graph = Example(network, gabf.structure(network))
    runs = [_solve(graph, law, start) for law, start in RUNS]
    return Report(
        name="example",
        config={"seed": seed},
        table=tuple(_row(graph, i) for i in range(1, network.n_nodes + 1)),
        verdicts=judge(CLAIMS, [graph]) + judge(RUN_CLAIMS, runs),
        figures={"example_graph.png": nine_node_graph(network, graph.optimum)},
        more={"runs": runs, "diameter": graph.optimum.diameter},
    )


def _row(graph: Example, i: int) -> Row:
    """x*, true parents P(i), the l of F_l and of S_l of node i."""
    found = graph.optimum
    parents = "{" + ", ".join(map(str, graph.parents(i))) + "}"
    return {"node": i, "x*": graph.x(i), "parents": parents, "F": found.longest[i - 1], "S": found.level[i - 1]}


def _solve(graph: Example, law: gabf.Law, start: str) -> Row:
    network = graph.network
    result = gabf.solve(network, law=law, x0=gabf.overestimate(network) if start == "above" else BELOW)
    certificates = [c for c in gabf.certify(network, law, result) if "printed" not in c.name]
    return {
        "law": law.name,
        "start": start,
        "outcome": result.outcome.key,
        "settling_tau": result.settling_tau,
        "settling_time": result.settling_time,
        "log10_remaining": result.log10_remaining,
        "error": gabf.max_error(result, graph.optimum.x_star),
        "bounds_held": sum(c.holds for c in certificates),
        "bounds": len(certificates),
    }


def _is_refused(network: gabf.Network, law: gabf.Law, x0: float) -> bool:
    try:
        gabf.solve(network, law=law, x0=x0)
    except AssumptionError:
        return True
    return False


def _numbers(indices: np.ndarray) -> Nodes:
    """Array indices in the paper's numbering, ascending."""
    return tuple(int(k) + 1 for k in np.sort(indices))
