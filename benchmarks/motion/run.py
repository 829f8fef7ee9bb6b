"""``benchmarks motion``: the motions of a folder of planning problems."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.bench import require_left_to_problems, run_bench, software
from benchmarks.motion.case import measure
from benchmarks.motion.report import Row, to_markdown
from benchmarks.problems import Problem, find_problems
from benchmarks.results import Results
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.models.robot import Robot
from planner.problem.request import SERIAL, LimitsRequest, PlanRequest, WorkersRequest
from planner.trajectory.limits import MotionLimits


def bench_motion(
    folder: Path,
    out: Path,
    plain: PlanRequest,
    motion: LimitsRequest,
    progress: Progress = QUIET,
    python: str | None = None,
    workers: WorkersRequest = SERIAL,
) -> Results[Row]:
    """Plan every problem of :func:`find_problems` in ``folder`` as ``plain`` says, and time its path within limits.

    ``python`` is that of an environment with roboplan, whose time parametrization is then set beside ours.

    ``out`` gets ``motion.csv`` and ``motion.md``; rows that are there already are kept. Raises OptionError for options
    that the problem decides, LimitError for limits that the robot does not allow, FileError for unusable folders.
    """
    require_left_to_problems(plain)
    if not isinstance(plain.robot, str):
        raise OptionError("give the robot by its name or its URDF.")
    robot = Robot.load(plain.robot)
    limits = MotionLimits.of(robot, motion).text(robot)
    asked = {"robot": plain.robot, "collision": plain.collision, "nodes": plain.nodes, "limits": limits}
    asked |= {"seed": plain.seed, "software": software()}
    return run_bench(
        out,
        "motion",
        Row,
        find_problems(folder),
        lambda table, problem: table.find(_row(problem, plain, asked, outcome="", message="").key),
        partial(_measured, plain=plain, motion=motion, asked=asked, python=python),
        to_markdown,
        "problems",
        progress,
        lambda row: (row.robot, row.collision, row.nodes, row.limits, row.problem, row.seed),
        workers,
    )


def _measured(
    problem: Problem,
    progress: Progress,
    plain: PlanRequest,
    motion: LimitsRequest,
    asked: dict[str, Any],
    python: str | None,
) -> list[Row]:
    """The row of a problem; none where stopped."""
    request = problem.asked(plain)
    columns = measure(request, motion, progress.renamed(lambda stage, done, total: None), python)
    return [] if progress.stopped else [_row(problem, plain, asked, **columns)]


def _row(problem: Problem, plain: PlanRequest, asked: dict[str, Any], **columns: Any) -> Row:
    return Row(problem=problem.name, kind=problem.kind, content=problem.content(plain), **asked, **columns)
