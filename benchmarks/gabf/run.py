"""Measures how fast and how exact the dynamics are, against SciPy's Dijkstra and RK45 on the same networks.

How. A network has uniform points in a square, each linked to its nearest 8, about 9.7 arcs a node. Times are medians of
interleaved runs in one process per size; on a shared machine read the ratios, not the seconds. Dijkstra gets a matrix
made beforehand, GABF the bare arrays. RK45 runs up to 10,000 nodes on the leanest right side, rtol 1e-6, atol 1e-6, in
tau to 1.1 times GABF's settling tau and in t to 0.9975 T_p. Errors are max |x - x*| / max(1, |x*|) against Dijkstra.
Limitations. RK45 does not settle, so its time is what it takes to get there. The networks are planar, the start is
above x*, the law singularity-free with its defaults: other graphs and starts below take other times.

Columns. One method on one network.

``seconds``: median of ``repeats`` runs; ``work``: steps, or evaluations of the right side. The peak memory (MiB) is
that of a process which loads the network and runs GABF.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import bench
from benchmarks.gabf.case import geometric_network, write_network
from benchmarks.text import markdown_table
from planner.base.errors import OptionError, PlannerError
from planner.base.progress import Progress
from planner.problem.request import RoadmapQuality

_NEIGHBOURS, _RK45_UP_TO = 8, 10_000
_METHODS = ("dijkstra", "gabf", "rk45 in tau", "rk45 in t")


def gabf(
    out: bench.Out = Path("bench-gabf"),
    seed: int = 0,
    sizes: tuple[int, ...] = (1_000, 4_000, 10_000, 20_000, 100_000),
    debug: bench.Debug = False,
) -> int:
    """The dynamics against SciPy's RK45 and scipy.sparse.csgraph.dijkstra on random geometric networks.

    Args:
        seed: Seed of the networks.
        sizes: Numbers of nodes; 1000000 takes minutes and 1.3 GiB.
    """
    RoadmapQuality(seed=seed)  # refuses a seed out of range
    if any(nodes <= _NEIGHBOURS + 1 for nodes in sizes):
        raise OptionError(f"sizes must be at least {_NEIGHBOURS + 2} nodes, got {min(sizes)}.")
    cases = []
    for nodes in sizes:
        names = "method nodes neighbours seed"
        rows = [bench.make_settings(names, method, nodes, _NEIGHBOURS, seed) for method in _methods(nodes)]
        cases.append(bench.Case(rows, (nodes, seed)))
    return bench.run_bench(BENCH, out, cases, _measure)


def _methods(nodes: int) -> tuple[str, ...]:
    return _METHODS if nodes <= _RK45_UP_TO else _METHODS[:2]


def _measure(task: tuple[int, int], progress: Progress) -> list[dict[str, Any]] | None:
    """Every method on one network, in a fresh process."""
    nodes, seed = task
    with tempfile.TemporaryDirectory() as place:
        network = Path(place) / "network.npz"
        write_network(geometric_network(nodes, _NEIGHBOURS, np.random.default_rng(seed)), network)
        options = {
            "network": str(network),
            "repeats": max(3, min(31, round(31 * (1_000 / nodes) ** 0.5))),
            "rk45_repeats": max(1, min(3, 3_000 // nodes)) if nodes <= _RK45_UP_TO else 0,
        }
        found = bench.measure_apart("benchmarks.gabf.case", options, progress)
    if isinstance(found, dict):
        raise PlannerError(found["message"])
    return found


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """A line per size, and how the times grow."""
    header = ["nodes", "arcs", "GABF (s)", "steps", "settling tau", "GABF error", "Dijkstra (s)", "GABF / Dijkstra"]
    header += ["RK45 in tau (s)", "/ GABF", "error", "RK45 in t (s)", "/ GABF", "error", "loaded (MiB)", "peak (MiB)"]
    sizes = sorted({row.nodes for row in rows})
    lines = [_cells({row.method: row for row in rows if row.nodes == nodes}) for nodes in sizes]
    text = ", ".join(f"{name} n^{slope:.2f}" for name, slope in growth_exponents(rows).items()) or "needs two sizes"
    return [*markdown_table(header, lines, texts=0), "", f"Growth of the time with the nodes, fitted: {text}."]


def _cells(of: dict[str, bench.Row]) -> list[Any]:
    ours, dijkstra = of["gabf"], of["dijkstra"]
    cells: list[Any] = [ours.nodes, ours.arcs, ours.seconds, ours.work, ours.settling_tau, ours.error]
    cells += [dijkstra.seconds, ours.over_dijkstra]
    for method in _METHODS[2:]:
        row = of.get(method)
        cells += [row.seconds, row.over_gabf, row.error] if row else [None, None, None]
    return [*cells, ours.memory_loaded_mib, ours.memory_peak_mib]


def growth_exponents(rows: Sequence[bench.Row]) -> dict[str, float]:
    """The exponent of the time over the nodes, for each method measured at two sizes or more."""
    found = {
        name: bench.growth_exponent((row.nodes, row.seconds) for row in rows if row.method == name) for name in _METHODS
    }
    return {name: slope for name, slope in found.items() if slope is not None}


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """The speed that GABF is meant to have; of 0 where the size was not measured."""
    ours = {row.nodes: row for row in rows if row.method == "gabf"}
    rk45 = [row for row in rows if row.method.startswith("rk45") and row.nodes == 1_000]
    near = [ours[nodes] for nodes in (1_000, 100_000) if nodes in ours]
    large = [ours[nodes] for nodes in (1_000_000,) if nodes in ours]
    return (
        bench.tally(
            "At 1e3 nodes GABF is 60 times faster than RK45, with a smaller error.",
            (row.over_gabf >= 60.0 and ours[row.nodes].error < row.error for row in rk45),
            "; ".join(f"{row.method}: {row.over_gabf:.0f} times, error {row.error:.1e}" for row in rk45),
        ),
        bench.tally(
            "GABF takes at most 60 times as long as Dijkstra at 1e3 and 1e5 nodes.",
            (row.over_dijkstra <= 60.0 for row in near),
            "; ".join(f"{row.nodes} nodes: {row.over_dijkstra:.0f} times" for row in near),
        ),
        bench.tally(
            "1e6 nodes settle within 3 GiB.",
            (row.settling_tau is not None and (row.memory_peak_mib or np.inf) <= 3 * 1024 for row in large),
            "; ".join(f"{row.arcs} arcs: {(row.memory_peak_mib or np.nan) / 1024:.2f} GiB" for row in large),
        ),
    )


BENCH = bench.Bench("gabf", __doc__, tables, aims)
