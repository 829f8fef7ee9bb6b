"""The rows of ``benchmarks gabf``: their flat file, what they add up to, and the table for people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.bench import aim_lines, closing_lines, growth_exponent
from planner.base.tables import markdown_table
from reproduce.verdict import Verdict, tally


@dataclass(frozen=True)
class Row:
    """One method on one network; the first five fields and ``software`` say which, the others what came out.

    ``seconds``: median of ``repeats`` interleaved runs. ``over_dijkstra`` and ``over_gabf``: ratios of those medians.
    ``error``: max |x - x*| / max(1, |x*|) at the end. ``work``: steps, or evaluations of the right side. The peak
    memory (MiB) is that of a process which loads the network and runs GABF, and nothing else before.
    """

    method: str
    nodes: int
    arcs: int
    neighbours: int
    seed: int
    seconds: float
    repeats: int
    over_dijkstra: float
    over_gabf: float
    error: float
    work: int | None
    settling_tau: float | None
    memory_loaded_mib: float | None
    memory_peak_mib: float | None
    software: str

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.nodes, self.neighbours, self.seed, self.software


def growth_exponents(rows: Sequence[Row]) -> dict[str, float]:
    """The least-squares slope of log(seconds) against log(nodes), for each method measured at two sizes or more."""
    methods = dict.fromkeys(row.method for row in rows)
    growth = {name: growth_exponent((row.nodes, row.seconds) for row in rows if row.method == name) for name in methods}
    return {name: slope for name, slope in growth.items() if slope is not None}


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What GABF's speed is meant to be, and whether these rows show it; of 0 where the size was not measured."""
    gabf = {row.nodes: row for row in rows if row.method == "gabf"}
    rk45 = [row for row in rows if row.method.startswith("rk45") and row.nodes == 1_000]
    near = [gabf[nodes] for nodes in (1_000, 100_000) if nodes in gabf]
    large = [gabf[nodes] for nodes in (1_000_000,) if nodes in gabf]
    return (
        tally(
            "At 1e3 nodes GABF is 60 times faster than RK45, with a smaller error.",
            (row.over_gabf >= 60.0 and gabf[row.nodes].error < row.error for row in rk45),
            "; ".join(f"{row.method}: {row.over_gabf:.0f} times, error {row.error:.1e}" for row in rk45),
        ),
        tally(
            "GABF takes at most 60 times as long as Dijkstra at 1e3 and 1e5 nodes.",
            (row.over_dijkstra <= 60.0 for row in near),
            "; ".join(f"{row.nodes} nodes: {row.over_dijkstra:.0f} times" for row in near),
        ),
        tally(
            "1e6 nodes settle within 3 GiB.",
            (row.settling_tau is not None and (row.memory_peak_mib or np.inf) <= 3 * 1024 for row in large),
            "; ".join(f"{row.arcs} arcs: {(row.memory_peak_mib or np.nan) / 1024:.2f} GiB" for row in large),
        ),
    )


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The table as Markdown: one line per size, with the growth exponents, the aims and what this does not measure."""
    lines = ["# python -m benchmarks gabf", "", *_size_table(rows), ""]
    lines += [f"Growth of the time with the nodes, fitted: {_growth_text(growth_exponents(rows))}.", ""]
    lines += [*aim_lines(aims(rows)), *closing_lines(rows, complete, "sizes", _LIMITATIONS)]
    return "\n".join(lines) + "\n"


_LIMITATIONS = """Limitations. Times are medians of interleaved runs in one process per size; on a shared machine read
the ratios, not the seconds. Dijkstra gets a matrix made beforehand, GABF the bare arrays. RK45 runs on the leanest
right side, rtol 1e-6, atol 1e-6, in tau to 1.1 times GABF's settling tau and in t to 0.9975 T_p; it does not settle, so
its time is what it takes to get there. The networks are planar, the start is above x*, the law singularity-free with
its defaults: other graphs and starts below take other times."""


def _size_table(bench: Sequence[Row]) -> list[str]:
    header = ["nodes", "arcs", "GABF (s)", "steps", "settling tau", "GABF error", "Dijkstra (s)", "GABF / Dijkstra"]
    header += ["RK45 in tau (s)", "/ GABF", "error", "RK45 in t (s)", "/ GABF", "error", "loaded (MiB)", "peak (MiB)"]
    sizes = sorted({row.nodes for row in bench})
    return markdown_table(
        header, (_size_cells({row.method: row for row in bench if row.nodes == nodes}) for nodes in sizes), texts=0
    )


def _size_cells(of: dict[str, Row]) -> list[Any]:
    gabf, dijkstra = of["gabf"], of["dijkstra"]
    cells: list[Any] = [gabf.nodes, gabf.arcs, gabf.seconds, gabf.work, gabf.settling_tau, gabf.error]
    cells += [dijkstra.seconds, gabf.over_dijkstra]
    for method in ("rk45 in tau", "rk45 in t"):
        row = of.get(method)
        cells += [row.seconds, row.over_gabf, row.error] if row else [None, None, None]
    return [*cells, gabf.memory_loaded_mib, gabf.memory_peak_mib]


def _growth_text(growth: dict[str, float]) -> str:
    return ", ".join(f"{method} n^{slope:.2f}" for method, slope in growth.items()) or "needs two sizes"
