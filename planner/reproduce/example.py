"""``planner reproduce example``: the nine-node graph of fig. (example1), and everything the text says of it."""

from __future__ import annotations

import numpy as np

from planner import gabf
from planner.base.errors import AssumptionError
from planner.problem.request import require_seed
from planner.reproduce.report import Report, Row, Verdict, require_figures, tally

Nodes = tuple[int, ...]
"""Nodes in the paper's numbering, which starts at 1."""

_BELOW = 1.0
"""The lowest start that the kernel's domain a >= 1 allows; no x_i* of a non-source node is as low."""

_RUNS: tuple[tuple[gabf.Law, str], ...] = (
    *((law, "above") for law in (gabf.Nominal(), gabf.PrescribedTime(), gabf.FixedTime(), gabf.SingularityFree())),
    *((law, "below") for law in (gabf.FixedTime(), gabf.SingularityFree())),
)


def run_example(seed: int = 0) -> Report:
    """Check what the text says of its example, and solve it under every law from every start that the law allows.

    The weights are ours, the figure not being part of the paper's source: :func:`planner.gabf.examples.nine_node`.
    ``seed`` is kept in the report, nothing here is random. Raises FileError where matplotlib is missing, OptionError
    for a seed out of range.
    """
    require_seed(seed)
    require_figures()
    from planner.figures.laws import nine_node_graph

    network = gabf.examples.nine_node()
    found = gabf.structure(network)
    runs = tuple(_solve(network, law, start, found.x_star) for law, start in _RUNS)
    return Report(
        name="example",
        config={"seed": seed},
        table=tuple(example_table(network, found)),
        verdicts=(*example_verdicts(network, found), *_run_verdicts(network, runs)),
        figures={"example_graph.png": nine_node_graph(network, found)},
        more={"runs": list(runs), "diameter": found.diameter},
    )


def example_table(network: gabf.Network, found: gabf.Structure) -> list[Row]:
    """One line per node: x*, true parents P(i), the l of F_l and of S_l."""
    return [
        {
            "node": i,
            "x*": float(found.x_star[i - 1]),
            "parents": _text(parents(network, found, i)),
            "F": int(found.longest[i - 1]),
            "S": int(found.level[i - 1]),
        }
        for i in range(1, network.n_nodes + 1)
    ]


def example_verdicts(network: gabf.Network, found: gabf.Structure) -> tuple[Verdict, ...]:
    """The sentences of definitions (true) and (longest) on their example."""
    x, sources = found.x_star, _numbers(network.sources)
    from_4, from_6 = optimal_paths(network, found, 4), optimal_paths(network, found, 6)
    members = [_numbers(np.flatnonzero(found.longest == level)) for level in range(found.diameter)]
    return (
        tally(
            "The graph consists of 9 nodes: 2 source nodes (nodes 1 and 9) and 7 non-source nodes.",
            [network.n_nodes == 9 and sources == (1, 9)],
            f"{network.n_nodes} nodes, sources {_text(sources)}",
        ),
        tally("x_1* = x_9* = 1.", [x[0] == 1.0 and x[8] == 1.0], f"x_1* = {x[0]:g}, x_9* = {x[8]:g}"),
        tally(
            "x_4* = 7 is achievable via paths 4 -> 2 -> 1 or 4 -> 3 -> 1.",
            [x[3] == 7.0 and {(4, 2, 1), (4, 3, 1)} <= set(from_4)],
            f"x_4* = {x[3]:g} via {_paths(from_4)}",
        ),
        tally("P(4) = {2, 3}.", [parents(network, found, 4) == (2, 3)], f"P(4) = {_text(parents(network, found, 4))}"),
        tally(
            "D(G) = 3, indicated by paths like 6 -> 8 -> 9.",
            [found.diameter == 3 and (6, 8, 9) in from_6],
            f"D(G) = {found.diameter} nodes",
        ),
        tally(
            "Node 6 has two optimal paths to its nearest source: 6 -> 8 -> 9 and 6 -> 9, both of which yield x_6* = 7.",
            [set(from_6) == {(6, 8, 9), (6, 9)} and x[5] == 7.0],
            f"x_6* = {x[5]:g} via {_paths(from_6)}",
        ),
        tally(
            "6 is in F_2 but not in F_1.",
            [6 in members[2] and 6 not in members[1]] if found.diameter > 2 else [False],
            "; ".join(f"F_{level} = {_text(nodes)}" for level, nodes in enumerate(members)),
        ),
        tally(
            "F_0 = S, the union of all F_l is V, and no two of them meet.",
            [members[0] == sources and sorted(sum(members, ())) == list(range(1, network.n_nodes + 1))],
            f"{sum(map(len, members))} nodes in {len(members)} sets",
        ),
    )


def parents(network: gabf.Network, found: gabf.Structure, i: int) -> Nodes:
    """P(i), definition (true)."""
    return _numbers(gabf.true_parents(network, found, i - 1))


def optimal_paths(network: gabf.Network, found: gabf.Structure, i: int) -> list[Nodes]:
    """Every optimal path from node i to a source, definition (longest); few enough to list in an example."""
    if i - 1 in network.sources:
        return [(i,)]
    return [(i, *rest) for j in parents(network, found, i) for rest in optimal_paths(network, found, j)]


def _solve(network: gabf.Network, law: gabf.Law, start: str, x_star: np.ndarray) -> Row:
    result = gabf.solve(network, law=law, x0=gabf.overestimate(network) if start == "above" else _BELOW)
    certificates = [c for c in gabf.certify(network, law, result) if "printed" not in c.name]
    return {
        "law": law.name,
        "start": start,
        "outcome": result.outcome.key,
        "settling_tau": result.settling_tau,
        "settling_time": result.settling_time,
        "log10_remaining": result.log10_remaining,
        "error": gabf.max_error(result, x_star),
        "bounds_held": sum(c.holds for c in certificates),
        "bounds": len(certificates),
    }


def _run_verdicts(network: gabf.Network, runs: tuple[Row, ...]) -> tuple[Verdict, ...]:
    refusal = None
    try:
        gabf.solve(network, law=gabf.PrescribedTime(), x0=_BELOW)
    except AssumptionError as error:
        refusal = f"refused, nodes by array index: {error}"
    return (
        tally(
            "The state of every node stabilises at x_i* under each law, from each start that its theorem allows.",
            (run["outcome"] == gabf.Ending.SETTLED.key and run["error"] <= 1e-12 for run in runs),
            "; ".join(f"{run['law']} from {run['start']}: t = {run['settling_time']:.4g}" for run in runs),
        ),
        tally(
            "The overestimation assumption applies to the prescribed-time strategy: it is refused a start below x*.",
            [refusal is not None],
            refusal or "not refused",
        ),
        tally(
            "(ours) Every bound of the paper that applies to a run holds on it, T_* as printed left aside.",
            (run["bounds_held"] == run["bounds"] for run in runs),
            f"{sum(run['bounds'] for run in runs)} bounds",
        ),
    )


def _numbers(indices: np.ndarray) -> Nodes:
    """Array indices in the paper's numbering, ascending."""
    return tuple(int(k) + 1 for k in np.sort(indices))


def _text(nodes: Nodes) -> str:
    return "{" + ", ".join(map(str, nodes)) + "}"


def _paths(paths: list[Nodes]) -> str:
    return ", ".join(" -> ".join(map(str, path)) for path in paths)
