"""``benchmarks first-motion``: a motion for every problem in a folder, by several planners in one run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.bench import plain_options, require_left_to_problems, run_bench, run_case, software
from benchmarks.first_motion.report import OMPL, OTHERS, OURS, WHOLE, Row, to_markdown
from benchmarks.problems import Problem, find_problems
from benchmarks.results import Results
from planner.base.errors import OptionError
from planner.base.files import is_file
from planner.base.progress import QUIET, Progress
from planner.batch.outcomes import CRASHED
from planner.models.robot import Robot
from planner.problem.request import LimitsRequest, PlanRequest
from planner.trajectory.limits import MotionLimits


@dataclass(frozen=True)
class _Run:
    """One problem by one method; ``python`` is empty for those that run in this environment."""

    problem: Problem
    method: str
    python: str
    request: PlanRequest
    motion: LimitsRequest
    limits: str
    seconds: float

    @property
    def blank(self) -> Row:
        """The row before anything was measured."""
        request = self.request
        asked = request.seed, str(request.robot), request.collision, self.limits, self.seconds
        return Row(self.problem.name, self.method, *asked, self.problem.content(request), software(), CRASHED)


def environments(given: Sequence[str]) -> dict[str, str]:
    """The path of each Python by the name of its planner, out of NAME=PATH; :class:`OptionError` for other text."""
    found = {}
    for text in given:
        name, _, path = text.partition("=")
        if name not in OTHERS or not is_file(Path(path)):
            raise OptionError(
                f"python '{text[:200]}' is not usable: give NAME=PATH, a planner of {', '.join(OTHERS)} and the Python "
                "of the environment that it is installed in, such as roboplan=/opt/roboplan/bin/python."
            )
        found[name] = path
    return found


def bench_first_motion(
    folder: Path,
    out: Path,
    plain: PlanRequest,
    motion: LimitsRequest,
    pythons: Mapping[str, str],
    seconds: float = 10.0,
    progress: Progress = QUIET,
) -> Results[Row]:
    """Every problem in ``folder`` by us, by OMPL, and by the planners whose environments ``pythons`` gives.

    By us twice: a path only, and the whole roadmap. Motions keep to the limits of ``motion``; the others search
    for at most ``seconds``. Writes ``first-motion.csv`` and ``first-motion.md`` to ``out``; rows that are there already
    are kept. Raises OptionError for numbers out of range, LimitError for limits that the robot does not allow,
    FileError where a folder cannot be used.
    """
    require_left_to_problems(plain)
    if not seconds > 0:
        raise OptionError("give a time above 0 s.")
    robot = Robot.load(str(plain.robot))
    limits = MotionLimits.of(robot, motion).text(robot)
    methods = {OURS: "", WHOLE: "", OMPL: "", **pythons}
    runs = [
        _Run(problem, method, python, problem.asked(plain), motion, limits, seconds)
        for problem in find_problems(folder)
        for method, python in methods.items()
    ]
    return run_bench(
        out,
        "first-motion",
        Row,
        runs,
        lambda table, run: table.find(run.blank.key),
        _measure,
        to_markdown,
        "runs",
        progress,
    )


def _measure(run: _Run, progress: Progress) -> list[Row]:
    """The row of one run, in a process of its own; none where stopped."""
    options = {
        "method": run.method,
        "python": run.python,
        "request": plain_options(run.request),
        "motion": {
            name: value and str(value) if name == "limits" else value for name, value in vars(run.motion).items()
        },
        "seconds": run.seconds,
    }
    ended, found = run_case("benchmarks.first_motion.case", options, progress)
    if ended.code is None:
        return []
    return [replace(run.blank, **found) if found is not None else replace(run.blank, message=ended.fault)]
