"""``planner bench gabf``: GABF beside SciPy's RK45 and Dijkstra, from a thousand nodes to a million, in one run."""

from __future__ import annotations

import json
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from planner.benchmark.gabf_case import geometric_network, save_network
from planner.benchmark.gabf_rows import GabfBench, Row, read_rows, summarise, to_csv, to_markdown
from planner.errors import OptionError, PlannerError
from planner.experiments.report import Progress, versions
from planner.files import make_folder, write_whole

SIZES = (1_000, 10_000, 100_000, 1_000_000)
CSV_NAME, MARKDOWN_NAME = "gabf.csv", "gabf.md"

Stop = Callable[[], bool]


def bench_gabf(
    folder: Path,
    sizes: Sequence[int] = SIZES,
    neighbours: int = 8,
    seed: int = 0,
    rk45_up_to: int = 10_000,
    progress: Progress = lambda stage, done, total: None,
    stop: Stop = lambda: False,
) -> GabfBench:
    """Measure what ``gabf.csv`` under ``folder`` does not hold yet, size by size, and write it and ``gabf.md`` anew.

    Each network has ``sizes`` nodes linked to their nearest ``neighbours``, about 9.7 arcs a node at 8. RK45 takes
    part up to ``rk45_up_to`` nodes: it is slow. A row counts as measured if it has the same nodes, neighbours, seed
    and versions of the software. ``progress`` hears ("sizes", done, total); once ``stop`` returns True the size at
    hand is abandoned. Raises OptionError for a size or neighbours out of range, FileError where the folder cannot
    be used.
    """
    for nodes in sizes:
        if not 1 <= neighbours < nodes or nodes < 10:
            raise OptionError(f"{nodes} nodes with {neighbours} neighbours each: give at least 10, and more nodes.")
    make_folder(folder)
    kept, asked = read_rows(folder / CSV_NAME), []
    for done, nodes in enumerate(sizes, start=1):
        found = _measured(kept, nodes, neighbours, seed, rk45_up_to)
        if found is None:
            found = _measure(nodes, neighbours, seed, rk45_up_to, stop)
            if found is None:
                break
            kept = [row for row in kept if _key(row) != _key(found[0])] + found
            write_whole(folder / CSV_NAME, to_csv(kept).encode())
        asked += found
        progress("sizes", done, len(sizes))
    bench = summarise(asked, complete={row.nodes for row in asked} == set(sizes))
    write_whole(folder / MARKDOWN_NAME, to_markdown(bench).encode())
    return bench


def _key(row: Row) -> tuple:
    return row.nodes, row.neighbours, row.seed, row.software


def _software() -> str:
    return ", ".join(f"{name} {version}" for name, version in versions().items()) + f" on {platform.machine()}"


def _measured(rows: Sequence[Row], nodes: int, neighbours: int, seed: int, rk45_up_to: int) -> list[Row] | None:
    """The rows of this network that are there already, or None where a method is missing."""
    found = [row for row in rows if _key(row) == (nodes, neighbours, seed, _software())]
    needed = {"gabf", "dijkstra"} | ({"rk45 in tau", "rk45 in t"} if nodes <= rk45_up_to else set())
    return found if needed <= {row.method for row in found} else None


def _measure(nodes: int, neighbours: int, seed: int, rk45_up_to: int, stop: Stop) -> list[Row] | None:
    """Every method on one network, in a fresh process; None where interrupted."""
    options = {
        "repeats": max(3, min(31, round(31 * (1_000 / nodes) ** 0.5))),
        "rk45_repeats": max(1, min(3, 3_000 // nodes)) if nodes <= rk45_up_to else 0,
    }
    with tempfile.TemporaryDirectory() as place:
        network, out = Path(place) / "network.npz", Path(place) / "rows.json"
        save_network(geometric_network(nodes, neighbours, np.random.default_rng(seed)), network)
        if not _in_process([str(network), str(out), json.dumps(options)], stop):
            return None
        return _rows(json.loads(out.read_text()), neighbours, seed)


def _in_process(arguments: list[str], stop: Stop) -> bool:
    """Run the measurement, in a session of its own so that Ctrl-C reaches us and not it; False where stopped."""
    command = [sys.executable, "-P", "-m", "planner.benchmark.gabf_case", *arguments]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        try:
            while process.poll() is None:
                if stop():
                    return False
                _wait(process)
        finally:
            if process.poll() is None:
                process.kill()
        if process.returncode:
            reason = (process.stderr.read() if process.stderr else "").strip().splitlines()
            raise PlannerError(f"the measurement ended with code {process.returncode}: {reason[-1] if reason else ''}")
    return True


def _wait(process: subprocess.Popen) -> None:
    try:
        process.wait(timeout=0.2)
    except subprocess.TimeoutExpired:
        return


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
            software=_software(),
        )
        for timing in timings
    ]
