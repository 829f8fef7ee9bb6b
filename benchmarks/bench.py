"""What all benchmarks share: rows measured where they are missing, the report beside them, and how it ends."""

from __future__ import annotations

import json
import operator
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from benchmarks.results import Results, ResultsFile, measure_missing
from planner.base import versions
from planner.base.errors import OptionError
from planner.base.files import make_folder, write_whole
from planner.base.progress import QUIET, Progress
from planner.batch.parallel import Measure
from planner.problem.request import SERIAL, PlanRequest, SweepRequest, WorkersRequest
from reproduce.verdict import Verdict

C = TypeVar("C")
R = TypeVar("R")
"""A frozen dataclass whose fields are texts, numbers, truth values, or None where there is no value."""

_HERE = Path(__file__).resolve().parent


def run_bench(
    folder: Path,
    name: str,
    kind: type[R],
    cases: Sequence[C],
    cached: Callable[[ResultsFile[R], C], list[R]],
    measure: Measure[C, list[R] | None],
    to_markdown: Callable[[Sequence[R], bool], str],
    stage: str,
    progress: Progress,
    order: Callable[[R], Any] | None = None,
    workers: WorkersRequest = SERIAL,
) -> Results[R]:
    """:func:`measure_missing` on ``<name>.csv`` of ``folder``, and its rows' report written to ``<name>.md`` beside.

    ``kind`` has a ``key``, what was asked. :class:`OptionError` where there are no cases, :class:`FileError` where the
    folder or the table cannot be used.
    """
    if not cases:
        raise OptionError(f"no {stage} to measure: give at least one value to each option that takes several.")
    make_folder(folder)
    key: Callable[[Any], Hashable] = operator.attrgetter("key")
    ledger = ResultsFile(folder / f"{name}.csv", kind, f"python -m benchmarks {name}", key, order)
    rows, complete = measure_missing(
        ledger, cases, lambda case: cached(ledger, case), measure, stage, progress, workers
    )
    report = to_markdown(rows, complete)
    write_whole(folder / f"{name}.md", report.encode())
    return Results(tuple(rows), report, complete)


def require_left_to_problems(plain: PlanRequest, *more: str) -> None:
    """Raise :class:`OptionError` for options, and ``more`` of them, that each problem says, or the benchmark itself."""
    default = PlanRequest()
    for name in ("scene", "motion_plan_request", "start", "goal", "roadmap", *more):
        if getattr(plain, name) != getattr(default, name):
            raise OptionError(f"{name} is what each problem says: leave it out.")


def closing_lines(rows: Iterable[Any], complete: bool, missing: str, method: str) -> list[str]:
    """How a report ends: what is missing where it was interrupted, the software of the rows, how it was measured."""
    lines = [] if complete else ["", f"Interrupted: the {missing} that were not measured are missing above."]
    return [*lines, "", *(f"Software: {text}." for text in dict.fromkeys(row.software for row in rows)), "", method]


def aim_lines(aims: Iterable[Verdict]) -> list[str]:
    """A line for each aim that there was something to judge by."""
    return [f"- {aim.confirmed} of {aim.of}: {aim.sentence} {aim.note}".rstrip() for aim in aims if aim.of]


def growth_exponent(points: Iterable[tuple[float, float]]) -> float | None:
    """The least-squares slope of log(seconds) against log(size) over (size, seconds); None for fewer than two sizes."""
    size, seconds = np.log(np.array(list(points), dtype=float).reshape(-1, 2)).T
    return float(np.polyfit(size, seconds, 1)[0]) if len(np.unique(size)) > 1 else None


def software() -> str:
    """Which software measured a row: versions, the source of the planner and of the benchmarks, the kind of machine."""
    return versions.software(_HERE)


@dataclass(frozen=True)
class Ended:
    """How a process ended: ``code`` is None where it was stopped, or ``over_time``.

    ``last_words``: the last line it wrote to standard error.
    """

    code: int | None
    seconds: float
    over_time: bool
    last_words: str

    @property
    def fault(self) -> str:
        """How a process failed."""
        return f"the process ended with code {self.code}: {self.last_words}"


def run_module(
    module: str, arguments: Sequence[str], progress: Progress = QUIET, time_limit: float | None = None
) -> Ended:
    """Run ``python -m module arguments`` until it ends, ``progress`` is stopped, or ``time_limit`` (s) has passed."""
    begin, over, killed = time.perf_counter(), False, False
    command = [sys.executable, "-m", module, *arguments]
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    ) as process:
        while True:
            try:
                lines = process.communicate(timeout=0.1)[1].decode(errors="replace").strip().splitlines()
                break
            except subprocess.TimeoutExpired:
                over = time_limit is not None and time.perf_counter() - begin > time_limit
                if over or progress.stopped:
                    process.kill()
                    killed = True
    seconds = time.perf_counter() - begin
    return Ended(None if killed else process.returncode, seconds, killed and over, lines[-1] if lines else "")


def run_case(
    module: str, options: Mapping[str, Any], progress: Progress = QUIET, time_limit: float | None = None
) -> tuple[Ended, Any]:
    """How ``python -m module OUT OPTIONS`` ended, and the content of OUT; None where it failed. Both are JSON."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "found.json"
        ended = run_module(module, [str(out), json.dumps(options)], progress, time_limit)
        return ended, json.loads(out.read_text()) if ended.code == 0 else None


def plain_options(request: SweepRequest) -> dict[str, Any]:
    """The options of a plan as JSON holds them."""
    return {name: str(value) if isinstance(value, Path) else value for name, value in asdict(request).items()}


def plan_request(options: Mapping[str, Any]) -> PlanRequest:
    """The request whose :func:`plain_options` these are."""
    names = ("srdf", "motion_plan_request", "roadmap")
    return PlanRequest(**{**options, **{name: Path(options[name]) for name in names if options.get(name)}})
