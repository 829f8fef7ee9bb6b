"""``benchmarks partition``: the dynamics on blocks, in one process and on two, against Dijkstra."""

from __future__ import annotations

import importlib.util
import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.bench import closing_lines, run_bench, software
from benchmarks.gabf.case import geometric_network
from benchmarks.partition.case import ACTORS, METHODS, WHOLE
from planner import gabf
from planner.base.errors import OptionError, PlannerError
from planner.base.progress import QUIET, Progress
from planner.base.tables import markdown_table
from planner.batch.results import Results, ResultsFile
from planner.problem.request import require_seed
from planner.processes.process import run_module

ARCS_PER_NODE = 9.7  # of geometric networks with 8 neighbours


@dataclass(frozen=True)
class Row:
    """One method on one network; ``steps_asked`` bounds the steps of the dynamics.

    ``load_s``, ``load_mib``: the network mapped from its file. ``prepare_s``: a run without steps, ``solve_s`` the
    whole. ``boundary``: states that some other block reads; ``told``: states told in all, 8 bytes each, in ``calls``
    calls of all blocks. ``mib``, ``worker_mib``: peak memory of the process, and of a worker. ``x_sha256``: of x, to be
    compared with that of one process.
    """

    nodes: int
    method: str
    blocks: int
    steps_asked: int
    seed: int
    software: str
    arcs: int
    load_s: float
    load_mib: float
    prepare_s: float | None = None
    solve_s: float | None = None
    steps: int | None = None
    settled: bool | None = None
    boundary: int | None = None
    told: int | None = None
    calls: int | None = None
    mib: float | None = None
    worker_mib: float | None = None
    x_sha256: str = ""

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.nodes, self.method, self.blocks, self.steps_asked, self.seed, self.software

    @property
    def step_s(self) -> float | None:
        """Seconds a step, without preparation."""
        return (self.solve_s - self.prepare_s) / self.steps if self.solve_s and self.prepare_s and self.steps else None


@dataclass(frozen=True)
class _Case:
    nodes: int
    blocks: int
    steps: int
    seed: int
    methods: tuple[str, ...]

    def key(self, method: str) -> tuple:
        return self.nodes, method, self.blocks, self.steps, self.seed, software()


def bench_partition(
    out: Path,
    arcs: Sequence[int] = (100_000, 1_000_000),
    blocks: int = 2,
    steps: int = 300_000,
    seed: int = 0,
    progress: Progress = QUIET,
) -> Results[Row]:
    """Random geometric networks of about ``arcs`` arcs, cut into ``blocks``, for at most ``steps`` steps.

    Actors take part where Dask is installed, on a cluster of this machine. Writes ``partition.csv`` and
    ``partition.md``; rows that are there are kept. Raises OptionError for numbers out of range.
    """
    require_seed(seed)
    if blocks < 2 or steps < 1 or not all(100 <= count <= 10**9 for count in arcs):
        raise OptionError("give at least 2 blocks, 1 step, and networks of 100 to 1000000000 arcs.")
    has_dask = importlib.util.find_spec("distributed") is not None
    methods = tuple(name for name in METHODS if name != ACTORS or has_dask)
    cases = [_Case(round(count / ARCS_PER_NODE), blocks, steps, seed, methods) for count in arcs]
    return run_bench(out, "partition", Row, cases, _kept, _measure, to_markdown, "networks", progress)


def _kept(table: ResultsFile[Row], case: _Case) -> list[Row]:
    found = [row for method in case.methods for row in table.find(case.key(method))]
    return found if len(found) == len(case.methods) else []


def _measure(case: _Case, progress: Progress) -> list[Row]:
    """Every method in a process of its own; no row where stopped."""
    rows = []
    with tempfile.TemporaryDirectory() as place:
        file, answer = Path(place) / "network.npz", Path(place) / "row.json"
        network = geometric_network(case.nodes, 8, np.random.default_rng(case.seed))
        arcs = network.n_arcs
        gabf.write_network(network, file)
        del network
        for method in case.methods:
            options = {"method": method, "blocks": case.blocks, "steps": case.steps}
            arguments = [str(file), str(answer), json.dumps(options)]
            ended = run_module("benchmarks.partition.case", arguments, progress)
            if ended.code is None:
                return []
            if ended.code:
                raise PlannerError(f"the measurement ended with code {ended.code}: {ended.last_words}")
            rows.append(Row(*case.key(method), arcs=arcs, **json.loads(answer.read_text())))
    return rows


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """A line for each method and network, and from where on blocks would pay."""
    header = ["arcs", "method", "x as one process", "prepare (s)", "whole (s)", "steps", "step (ms)", "told a step"]
    header += ["process (MiB)", "worker (MiB)", "mapped (s)"]
    lines = ["# python -m benchmarks partition", "", *markdown_table(header, map(partial(_cells, rows), rows), 0), ""]
    lines += [f"- {line}" for line in _judgements(rows)]
    return "\n".join([*lines, *closing_lines(rows, complete, "networks", _METHOD)]) + "\n"


def _beside(rows: Sequence[Row], row: Row, method: str) -> Row | None:
    wanted = replace(row, method=method).key
    return next((other for other in rows if other.key == wanted), None)


def _cells(rows: Sequence[Row], row: Row) -> list:
    whole = _beside(rows, row, WHOLE)
    same = None if whole is None or row.steps is None else str(row.x_sha256 == whole.x_sha256)
    step = None if row.step_s is None else 1e3 * row.step_s
    told = None if row.told is None or not row.steps else round(row.told / row.steps)
    cells = [row.arcs, row.method, same, row.prepare_s, row.solve_s, row.steps, step, told]
    return [*cells, row.mib, row.worker_mib, row.load_s]


def _judgements(rows: Sequence[Row]) -> list[str]:
    """Of each network with actors: steps against one process, and where calls would cost no more than they save."""
    found = []
    for row in rows:
        whole = _beside(rows, row, WHOLE)
        if row.method != ACTORS or whole is None or not row.step_s or not whole.step_s:
            continue
        extra = row.step_s - whole.step_s / row.blocks
        share = f"a step on {row.blocks} actors takes {row.step_s / whole.step_s:.2f} of one in one process"
        even = row.arcs * extra / (whole.step_s * (1.0 - 1.0 / row.blocks))
        model = f", {1e3 * extra:.1f} ms of it for calls and exchange: as much as is saved at {even:.1g} arcs"
        found.append(f"{row.arcs} arcs: {share}{model if extra > 0 else ''}.")
    return found


_METHOD = """Limitations. Steps are timed by the wall; on a shared machine actors wait for processors that others use.
Premises, the start, reachability and the cut are computed by the process that asks, which therefore holds the network;
workers hold their blocks. Dijkstra is SciPy's, from one source, on a matrix made beforehand."""
