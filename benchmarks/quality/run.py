"""``benchmarks quality``: a folder of problems, planned at several betas and efforts and by OMPL's planners."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.bench import plain_options, require_left_to_problems, run_bench, run_case, software
from benchmarks.problems import Problem, find_problems
from benchmarks.quality.case import OURS
from benchmarks.quality.report import Row, to_markdown
from benchmarks.results import Results
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.batch.outcomes import CRASHED
from planner.problem.request import SERIAL, PlanRequest, WorkersRequest

METHODS = ("RRTConnect", "RRT*", "BIT*")


@dataclass(frozen=True)
class _Run:
    """One problem by one method; ``settings`` is empty for OMPL's planners."""

    problem: Problem
    method: str
    settings: str
    request: PlanRequest
    seconds: float

    @property
    def blank(self) -> Row:
        """The row before anything was measured."""
        asked = self.request.seed, self.request.collision, self.seconds, self.problem.content(self.request)
        return Row(self.problem.name, self.method, self.settings, *asked, software(), CRASHED)


def bench_quality(
    folder: Path,
    out: Path,
    plain: PlanRequest,
    betas: Sequence[float] = (0.0, 0.25, 0.5, 1.0),
    efforts: Sequence[int] = (0, 6),
    seconds: float = 5.0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Results[Row]:
    """Every problem in ``folder`` at every one of ``betas`` and ``efforts``, and by OMPL's planners.

    OMPL's planners get ``seconds`` of processor time each. Writes ``quality.csv`` and ``quality.md`` to ``out``; rows
    that are there already are kept. Raises OptionError for numbers out of range, FileError where a folder cannot be
    used.
    """
    require_left_to_problems(plain, "beta", "effort")
    if not betas or not efforts or seconds <= 0:
        raise OptionError("give at least one beta and one effort, and a time above 0 s.")
    runs = [run for problem in find_problems(folder) for run in _runs(problem, plain, betas, efforts, seconds)]
    return run_bench(
        out,
        "quality",
        Row,
        runs,
        lambda table, run: table.find(run.blank.key),
        _measure,
        to_markdown,
        "runs",
        progress,
        workers=workers,
    )


def _runs(
    problem: Problem, plain: PlanRequest, betas: Sequence[float], efforts: Sequence[int], seconds: float
) -> list[_Run]:
    request = problem.asked(plain)
    runs = [_Run(problem, method, "", request, seconds) for method in METHODS]
    for beta, effort in itertools.product(betas, efforts):
        settings = f"beta {beta:g}, effort {effort}, {plain.nodes} nodes"
        runs.append(_Run(problem, OURS, settings, replace(request, beta=beta, effort=effort), seconds))
    return runs


def _measure(run: _Run, progress: Progress) -> list[Row]:
    """The row of one run, in a process of its own; none where stopped."""
    options = {"method": run.method, "seconds": run.seconds, "request": plain_options(run.request)}
    ended, found = run_case("benchmarks.quality.case", options, progress)
    if ended.code is None:
        return []
    return [replace(run.blank, **found) if found is not None else replace(run.blank, message=ended.fault)]
