"""``benchmarks replan``: each problem of a folder, changed many times; new proven paths against planning anew."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks.bench import require_left_to_problems, run_bench, software
from benchmarks.replan.report import Row, to_markdown
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.batch.options import plain_options
from planner.batch.problems import Problem, find_problems
from planner.batch.results import Results, ResultsFile
from planner.problem.request import SERIAL, PlanRequest, RoadmapRequest, WorkersRequest
from planner.processes.process import run_case


def bench_replan(
    folder: Path,
    out: Path,
    plain: RoadmapRequest = RoadmapRequest("panda", collision="coal"),  # noqa: B008 (frozen)
    changes: int = 100,
    simulations: int = 50,
    time_limit: float = 1200.0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Results[Row]:
    """Change each problem of :func:`find_problems` ``changes`` times, then simulate moving boxes.

    Writes ``replan.csv`` and ``replan.md``.

    Each problem has a process of its own, which is killed after ``time_limit`` seconds. Problems that are measured
    already are kept. Raises OptionError for numbers out of range, FileError where a folder cannot be used.
    """
    request = PlanRequest(**vars(plain))
    require_left_to_problems(request)
    if changes < 1 or simulations < 0 or not time_limit > 0:
        raise OptionError("give at least one change, no negative number of simulations, and a time limit above 0 s.")
    problems = find_problems(folder)
    asked = str(plain.robot), plain.collision, plain.nodes, plain.seed, changes, simulations
    wide, ending = plain.widen_limits, (0, "none", "crashed")
    blanks = [
        Row(problem.name, *asked, problem.content(request), software(), *ending, widen_limits=wide)
        for problem in problems
    ]
    return run_bench(
        out,
        "replan",
        Row,
        list(zip(problems, blanks, strict=True)),
        lambda table, case: _kept(table, case[1]),
        partial(_measure, plain=request, time_limit=time_limit),
        to_markdown,
        "problems",
        progress,
        order=lambda row: row.key,
        workers=workers,
        isolated=True,
    )


def _kept(table: ResultsFile[Row], blank: Row) -> list[Row]:
    return [row for row in table.rows if row.asked == blank.asked]


def _measure(case: tuple[Problem, Row], progress: Progress, plain: PlanRequest, time_limit: float) -> list[Row]:
    """The rows of one problem; none where stopped."""
    problem, blank = case
    options = plain_options(problem.asked(plain)) | {"changes": blank.changes, "simulations": blank.simulations}
    ended, rows = run_case("benchmarks.replan.case", options, progress, time_limit, tries=2)
    if ended.over_time:
        return [replace(blank, outcome="timed out", message=f"Killed after {time_limit:g} s.")]
    if ended.code is None:
        return []
    if rows is None:
        return [replace(blank, message=f"{ended.fault[0].upper()}{ended.fault[1:]}")]
    return [replace(blank, number=k, **columns) for k, columns in enumerate(rows, start=1)]
