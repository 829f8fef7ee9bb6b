"""``benchmarks tables``: problems that were published with results, planned by us, and both side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.bench import plain_options, run_bench, run_case, software
from benchmarks.problems import find_problems
from benchmarks.results import Results
from benchmarks.tables.methods import asked_by
from benchmarks.tables.published import GCS, GCS_TASKS, MBM
from benchmarks.tables.report import Row, to_markdown
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.batch.outcomes import CRASHED
from planner.models.scene import Scene
from planner.problem.request import PlanRequest


@dataclass(frozen=True)
class _Run:
    """Tasks (start, goal) of one scene by one method; an empty start: the request's own."""

    method: str
    request: PlanRequest
    tasks: tuple[tuple[str, str], ...]
    blanks: tuple[Row, ...]  # of each task, before anything was measured


def bench_tables(
    out: Path,
    folder: Path | None = None,
    nodes: int = 1000,
    betas: Sequence[float] = (1.0, 0.5, 0.0),
    seed: int = 0,
    progress: Progress = QUIET,
) -> Results[Row]:
    """The five tasks of the GCS paper, and the problems in ``folder`` as MotionBenchMaker's for the Panda.

    Writes ``tables.csv`` and ``tables.md`` to ``out``; rows that are there already are kept. Raises OptionError for
    numbers out of range, FileError where a folder cannot be used.
    """
    if not betas:
        raise OptionError("give at least one beta.")
    plain = PlanRequest("iiwa14", GCS, collision="coal", nodes=nodes, seed=seed)
    runs = [_run(GCS, method, request, GCS_TASKS) for method, request in asked_by(plain, betas, kept=True).items()]
    plain = replace(plain, robot="panda", widen_limits=True)
    for problem in [] if folder is None else find_problems(folder):
        for method, request in asked_by(problem.asked(plain), betas, kept=False).items():
            runs.append(_run(MBM, method, request, (("", ""),), problem.name, problem.content(plain)))
    return run_bench(
        out,
        "tables",
        Row,
        runs,
        lambda table, run: [row for blank in run.blanks for row in table.find(blank.key)],
        _measure,
        to_markdown,
        "runs",
        progress,
    )


def _run(
    table: str,
    method: str,
    request: PlanRequest,
    tasks: tuple[tuple[str, str], ...],
    name: str = "",
    content: str | None = None,
) -> _Run:
    content = Scene.load(GCS).identity[:8] if content is None else content
    blanks = tuple(
        Row(
            table,
            name or f"{start} to {goal}",
            method,
            request.nodes,
            request.seed,
            request.collision,
            content,
            software(),
            CRASHED,
        )
        for start, goal in tasks
    )
    return _Run(method, request, tasks, blanks)


def _measure(run: _Run, progress: Progress) -> list[Row]:
    """The rows of one run, in a process of its own; none where stopped."""
    options = {"method": run.method, "tasks": run.tasks, "request": plain_options(run.request)}
    ended, found = run_case("benchmarks.tables.case", options, progress)
    if ended.code is None:
        return []
    if found is None:
        return [replace(blank, message=ended.fault) for blank in run.blanks]
    return [replace(blank, **row) for blank, row in zip(run.blanks, found, strict=True)]
