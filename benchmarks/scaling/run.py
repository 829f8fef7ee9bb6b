"""``benchmarks scaling``: one batch by one to all cores, what handing out a plan costs, and a model of more."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.bench import closing_lines, run_bench, software
from benchmarks.scaling.model import drawn, makespan
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.base.tables import markdown_table
from planner.batch.results import Results
from planner.batch.run import run_batch
from planner.batch.tasks import read_tasks
from planner.problem.request import PlanRequest, WorkersRequest
from planner.processes.parallel import measured_cases

PROBLEMS, WORKERS = 10_000, (1, 10, 100)
_EMPTY = 200  # tasks that do nothing, to measure what handing out one costs


@dataclass(frozen=True)
class Row:
    """One batch by so many ``jobs``; ``asked`` is a hash of its plans.

    ``wall_s``: from the first plan to the last row. ``plans_s``: the seconds of each plan's process, as JSON.
    ``dispatch_s``: what handing out one task and taking its answer back costs whoever does it. ``model_s``: what
    :func:`benchmarks.scaling.model.makespan` says of the same plans.
    """

    backend: str
    jobs: int
    plans: int
    asked: str
    software: str
    wall_s: float | None = None
    plans_s: str = ""
    dispatch_s: float | None = None
    model_s: float | None = None

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.backend, self.jobs, self.asked, self.software

    @property
    def seconds(self) -> list[float]:
        """The seconds of each plan."""
        return json.loads(self.plans_s)


def bench_scaling(
    source: Path,
    out: Path,
    plain: PlanRequest,
    jobs: Sequence[int] = (),
    scheduler: str | None = None,
    progress: Progress = QUIET,
) -> Results[Row]:
    """Plan all of ``source`` (see :func:`planner.batch.run.run_batch`) by every number of ``jobs``.

    From 1 to all cores where none are given, and with ``scheduler`` by a Dask cluster too. Writes ``scaling.csv`` and
    ``scaling.md`` to ``out``; rows that are there are kept. Raises :class:`PlannerError` for unusable input.
    """
    counts = tuple(jobs) or tuple(range(1, (os.cpu_count() or 1) + 1))
    workers = [WorkersRequest(count) for count in counts]
    if scheduler is not None:
        workers.append(WorkersRequest(counts[-1], "dask", scheduler))
    tasks = read_tasks(source, plain)
    if len(set(counts)) < len(counts) or len(tasks) < max(counts):
        raise OptionError(f"{len(tasks)} plans by {counts} jobs: give each number once, and no more than plans.")
    asked = hashlib.sha256(" ".join(task.asked for task in tasks).encode()).hexdigest()[:16]
    blank = Row("", 0, len(tasks), asked, software())
    return run_bench(
        out,
        "scaling",
        Row,
        workers,
        lambda table, who: table.find(replace(blank, backend=who.backend, jobs=who.jobs or 1).key),
        partial(_measure, source=source, plain=plain, blank=blank),
        to_markdown,
        "batches",
        progress,
        order=lambda row: row.key,
    )


def _measure(workers: WorkersRequest, progress: Progress, source: Path, plain: PlanRequest, blank: Row) -> list[Row]:
    """The row of one batch; none where stopped."""
    jobs, dispatch = workers.jobs or 1, dispatch_seconds(workers)
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:  # workers of a cluster see it too
        begin = time.perf_counter()
        quiet = progress.renamed(lambda stage, done, total: None)
        found = run_batch(source, Path(folder), plain, workers, progress=quiet)
        wall = time.perf_counter() - begin
    if not found.complete:
        return []
    seconds = [row.seconds or 0.0 for row in found.rows]
    return [
        replace(
            blank,
            backend=workers.backend,
            jobs=jobs,
            wall_s=wall,
            plans_s=json.dumps(seconds),
            dispatch_s=dispatch,
            model_s=makespan(seconds, jobs, dispatch),
        )
    ]


def dispatch_seconds(workers: WorkersRequest) -> float:
    """Seconds for each of many tasks that do nothing, starting of a pool or joining of a cluster left out."""
    ends = [time.perf_counter() for _ in measured_cases(range(_EMPTY), _nothing, workers, QUIET, isolated=True)]
    return (ends[-1] - ends[0]) / (_EMPTY - 1)


def _nothing(case: int, progress: Progress) -> int:
    return case


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The measured batches, the model beside them, and what it says of many more plans and workers."""
    header = ["backend", "jobs", "plans", "wall (s)", "model (s)", "speed-up", "plan, mean (s)", "handing out (ms)"]
    lines = ["# python -m benchmarks scaling", "", *markdown_table(header, map(partial(_cells, rows), rows)), ""]
    if rows:
        lines += [f"{PROBLEMS} problems like these, by the model:", "", *_predictions(rows)]
    return "\n".join([*lines, *closing_lines(rows, complete, "batches", _METHOD)]) + "\n"


def _cells(rows: Sequence[Row], row: Row) -> list:
    alone = next((one.wall_s for one in rows if one.jobs == 1 and one.backend == "processes"), None)
    speedup = None if alone is None or not row.wall_s else alone / row.wall_s
    mean, dispatch = float(np.mean(row.seconds)), 1e3 * (row.dispatch_s or 0.0)
    return [row.backend, row.jobs, row.plans, row.wall_s, row.model_s, speedup, mean, dispatch]


def _predictions(rows: Sequence[Row]) -> list[str]:
    lines = []
    for row in rows:
        many, dispatch = drawn(row.seconds, PROBLEMS, seed=0), row.dispatch_s or 0.0
        hours = [makespan(many, count, dispatch) / 3600.0 for count in WORKERS]
        most = float(np.mean(many)) / dispatch if dispatch else float("inf")
        lines.append([f"{row.backend}, plans as with {row.jobs} jobs", *hours, most])
    return markdown_table(["", *(f"{count} workers (h)" for count in WORKERS), "workers that gain"], lines)


_METHOD = """Limitations. A worker of the model is one that plans as quickly as here with that many jobs on this
machine; plans use several threads where they are free, so one job alone plans quicker than one of several. The model
draws plans from the measured ones, hands them out one after the other, and leaves out what workers share: disks, the
network, the time to start a cluster. Read the ratios: the machine may have had other work."""
