"""``benchmarks replan``: each problem of a folder, changed many times; new proven paths against planning anew."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks.bench import run_bench, software
from benchmarks.replan.report import Row, to_markdown
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.batch.problems import Problem, find_problems
from planner.batch.results import Results, ResultsFile
from planner.problem.request import (
    PAPER_NODES,
    SERIAL,
    Backend,
    PlanRequest,
    WorkersRequest,
    require_nodes,
    require_seed,
)
from planner.processes.process import run_case


def bench_replan(
    folder: Path,
    out: Path,
    robot: str = "panda",
    collision: Backend = "coal",
    nodes: int = PAPER_NODES,
    changes: int = 100,
    simulations: int = 50,
    seed: int = 0,
    time_limit: float = 1200.0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
    widen_limits: bool = False,
) -> Results[Row]:
    """Change each problem of :func:`find_problems` ``changes`` times, then simulate moving boxes.

    Writes ``replan.csv`` and ``replan.md``.

    Each problem has a process of its own, which is killed after ``time_limit`` seconds. Problems that are measured
    already are kept. Raises OptionError for numbers out of range, FileError where a folder cannot be used.
    """
    require_nodes(nodes)
    require_seed(seed)
    if changes < 1 or simulations < 0 or not time_limit > 0:
        raise OptionError("give at least one change, no negative number of simulations, and a time limit above 0 s.")
    problems = find_problems(folder)

    asked = robot, collision, nodes, seed, changes, simulations
    plain = PlanRequest(robot, collision=collision, nodes=nodes, seed=seed, widen_limits=widen_limits)
    blanks = [
        Row(
            problem.name,
            *(*asked, problem.content(plain), software()),
            *(0, "none", "crashed"),
            widen_limits=widen_limits,
        )
        for problem in problems
    ]
    return run_bench(
        out,
        "replan",
        Row,
        list(zip(problems, blanks, strict=True)),
        lambda table, case: _kept(table, case[1]),
        partial(_measure, time_limit=time_limit),
        to_markdown,
        "problems",
        progress,
        order=lambda row: row.key,
        workers=workers,
        isolated=True,
    )


def _kept(table: ResultsFile[Row], blank: Row) -> list[Row]:
    return [row for row in table.rows if row.asked == blank.asked]


def _measure(case: tuple[Problem, Row], progress: Progress, time_limit: float) -> list[Row]:
    """The rows of one problem; none where stopped."""
    problem, blank = case
    asked = "robot", "collision", "nodes", "seed", "changes", "simulations", "widen_limits"
    options = {name: getattr(blank, name) for name in asked}
    options |= {"scene": str(problem.scene), "motion_plan_request": str(problem.request)}
    ended, rows = run_case("benchmarks.replan.case", options, progress, time_limit, tries=2)
    if ended.over_time:
        return [replace(blank, outcome="timed out", message=f"Killed after {time_limit:g} s.")]
    if ended.code is None:
        return []
    if rows is None:
        return [replace(blank, message=f"{ended.fault[0].upper()}{ended.fault[1:]}")]
    return [replace(blank, number=k, **columns) for k, columns in enumerate(rows, start=1)]
