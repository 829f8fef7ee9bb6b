"""``benchmarks gabf``: GABF beside SciPy's RK45 and Dijkstra, from a thousand nodes to a million, in one run."""

from __future__ import annotations

import json
import operator
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import run_bench, run_module, software
from benchmarks.gabf.case import geometric_network, write_network
from benchmarks.gabf.report import Row, to_markdown
from benchmarks.results import Results, ResultsFile
from planner.base.errors import OptionError, PlannerError
from planner.base.progress import QUIET, Progress
from planner.problem.request import require_seed

SIZES = (1_000, 4_000, 10_000, 20_000, 100_000, 1_000_000)


def bench_gabf(
    folder: Path,
    sizes: Sequence[int] = SIZES,
    neighbours: int = 8,
    seed: int = 0,
    rk45_up_to: int = 10_000,
    progress: Progress = QUIET,
) -> Results[Row]:
    """Measure what ``gabf.csv`` under ``folder`` does not hold yet, size by size, and write it and ``gabf.md`` anew.

    Each network has ``sizes`` nodes linked to their nearest ``neighbours``, about 9.7 arcs per node at 8. RK45 takes
    part up to ``rk45_up_to`` nodes: it is slow. A row counts as measured if it has the same nodes, neighbours, seed
    and versions of the software. ``progress`` is called with ("sizes", done, total); once stopped the current size is
    abandoned. Raises OptionError for a size or neighbours out of range, FileError where the folder cannot
    be used.
    """
    require_seed(seed)
    for nodes in sizes:
        if not 1 <= neighbours < nodes or nodes < 10:
            raise OptionError(f"{nodes} nodes with {neighbours} neighbours each: give at least 10, and more nodes.")
    return run_bench(
        folder,
        "gabf",
        Row,
        sizes,
        lambda table, nodes: _measured(table, nodes, neighbours, seed, rk45_up_to),
        partial(_measure, neighbours=neighbours, seed=seed, rk45_up_to=rk45_up_to),
        to_markdown,
        "sizes",
        progress,
        order=operator.attrgetter("neighbours", "seed", "nodes"),
    )


def _measured(kept: ResultsFile[Row], nodes: int, neighbours: int, seed: int, rk45_up_to: int) -> list[Row]:
    """The rows of this network that are there already, none where a method is missing."""
    found = kept.find((nodes, neighbours, seed, software()))
    needed = {"gabf", "dijkstra"} | ({"rk45 in tau", "rk45 in t"} if nodes <= rk45_up_to else set())
    return found if needed <= {row.method for row in found} else []


def _measure(nodes: int, progress: Progress, neighbours: int, seed: int, rk45_up_to: int) -> list[Row]:
    """Every method on one network, in a fresh process; no row where interrupted."""
    options = {
        "repeats": max(3, min(31, round(31 * (1_000 / nodes) ** 0.5))),
        "rk45_repeats": max(1, min(3, 3_000 // nodes)) if nodes <= rk45_up_to else 0,
    }
    with tempfile.TemporaryDirectory() as place:
        network, out = Path(place) / "network.npz", Path(place) / "rows.json"
        write_network(geometric_network(nodes, neighbours, np.random.default_rng(seed)), network)
        ended = run_module("benchmarks.gabf.case", [str(network), str(out), json.dumps(options)], progress)
        if ended.code is None:
            return []
        if ended.code:
            raise PlannerError(f"the measurement ended with code {ended.code}: {ended.last_words}")
        return _rows(json.loads(out.read_text()), neighbours, seed)


def _rows(measured: dict[str, Any], neighbours: int, seed: int) -> list[Row]:
    timings = measured["timings"]
    seconds = {timing["method"]: timing["seconds"] for timing in timings}
    shared = {
        name: measured[name] for name in ("nodes", "arcs", "settling_tau", "memory_loaded_mib", "memory_peak_mib")
    }
    return [
        Row(
            **timing,
            **shared,
            neighbours=neighbours,
            seed=seed,
            over_dijkstra=timing["seconds"] / seconds["dijkstra"],
            over_gabf=timing["seconds"] / seconds["gabf"],
            software=software(),
        )
        for timing in timings
    ]
