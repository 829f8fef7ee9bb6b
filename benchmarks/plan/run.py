"""``benchmarks plan``: a folder of planning problems, each planned with several seeds, one row each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

from benchmarks.bench import plain_options, require_left_to_problems, run_case, software
from benchmarks.plan.ompl_log import write_logs
from benchmarks.plan.report import to_markdown
from benchmarks.plan.rows import Row
from benchmarks.problems import Problem, find_problems
from benchmarks.results import ResultsFile, measure_missing
from planner.base.errors import OptionError
from planner.base.files import make_folder, write_whole
from planner.base.progress import QUIET, Progress
from planner.batch.outcomes import CRASHED, TIMED_OUT
from planner.problem.request import SERIAL, PlanRequest, WorkersRequest

CSV_NAME, MARKDOWN_NAME, LOGS_NAME = "plan.csv", "plan.md", "logs"

_COLUMNS = ("robot", "collision", "nodes", "beta", "widen_limits")
_BY_PROBLEM = ("scene", "motion_plan_request", "seed")


@dataclass(frozen=True)
class PlanBench:
    """The rows asked for, and those of the same software that the folder held already, with other settings or seeds.

    ``report`` is about all of them, as Markdown. ``complete`` is False where it was interrupted.
    """

    rows: tuple[Row, ...]
    others: tuple[Row, ...]
    report: str
    complete: bool


def bench_plan(
    folder: Path,
    out: Path,
    plain: PlanRequest,
    seeds: Sequence[int] = (0, 1, 2),
    time_limit: float = 60.0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> PlanBench:
    """Plan every problem of :func:`find_problems` in ``folder`` with every seed, as ``plain`` says for all of them.

    Each run has a process of its own, which is killed and recorded as timed out after ``time_limit`` seconds; its
    budget is the plan's own, in counts. ``out`` gets ``plan.csv``, ``plan.md`` and a benchmark log of OMPL's kind a
    problem. A row that is there already is kept: the same problem and content of its files, seed, settings and
    software. Once it is asked to stop the current run is abandoned. Raises OptionError for options that the problem
    decides or numbers out of range, FileError where a folder cannot be used.
    """
    _require_usable(plain, seeds, time_limit)
    problems = find_problems(folder)
    make_folder(out)
    ledger = ResultsFile(out / CSV_NAME, Row, "python -m benchmarks plan", lambda row: row.key, lambda row: row.place)
    asked, complete = measure_missing(
        ledger,
        [(problem, replace(plain, seed=seed)) for problem in problems for seed in seeds],
        lambda run: _kept(ledger, _blank(*run, time_limit)),
        partial(_measure, time_limit=time_limit),
        "problems",
        progress,
        workers,
    )
    here, keys = software(), {row.key for row in asked}
    others = [row for row in ledger.rows if row.software == here and row.key not in keys]
    report = to_markdown([*asked, *others], complete)
    write_logs([*asked, *others], out / LOGS_NAME)
    write_whole(out / MARKDOWN_NAME, report.encode())
    return PlanBench(tuple(asked), tuple(others), report, complete)


def _require_usable(plain: PlanRequest, seeds: Sequence[int], time_limit: float) -> None:
    require_left_to_problems(plain, "seed")
    if not seeds or not time_limit > 0:
        raise OptionError("give at least one seed, and a time limit above 0 s.")
    for seed in seeds:
        replace(plain, seed=seed)  # refuses a seed that is out of range


def _kept(ledger: ResultsFile[Row], blank: Row) -> list[Row]:
    """The row that is there already, if it would have come out the same under this time limit."""
    limit = blank.time_limit_s
    return [
        row
        for row in ledger.find(blank.key)
        if (row.time_limit_s >= limit if row.outcome == TIMED_OUT else (row.process_s or 0.0) <= limit)
    ]


def _blank(problem: Problem, request: PlanRequest, time_limit: float) -> Row:
    default, taken = asdict(PlanRequest()), {*_COLUMNS, *_BY_PROBLEM}
    more = {k: v for k, v in asdict(request).items() if k not in taken and v != default[k]}
    return Row(
        problem=problem.name,
        kind=problem.kind,
        seed=request.seed,
        robot=str(request.robot),
        collision=request.collision,
        nodes_asked=request.nodes,
        beta=request.beta,
        widen_limits=request.widen_limits,
        options=", ".join(f"{name} {value}" for name, value in more.items()),
        time_limit_s=time_limit,
        content=problem.content(request),
        software=software(),
        outcome=CRASHED,
        message="",
    )


def _measure(run: tuple[Problem, PlanRequest], progress: Progress, time_limit: float) -> list[Row]:
    """The row of one run; none where stopped."""
    problem, request = run
    blank = _blank(problem, request, time_limit)
    options = plain_options(problem.asked(request))
    ended, found = run_case("benchmarks.plan.case", options, progress, time_limit)
    if ended.over_time:
        message = f"killed after {time_limit:g} s; raise --time-limit or lower --nodes."
        return [replace(blank, outcome=TIMED_OUT, message=message, process_s=ended.seconds)]
    if ended.code is None:
        return []
    if found is None:
        return [replace(blank, outcome=CRASHED, message=ended.fault, process_s=ended.seconds)]
    return [replace(blank, **found, process_s=ended.seconds)]
