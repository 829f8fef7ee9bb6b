"""What all benchmarks share: rows measured where they are missing, the report beside them, and how it ends."""

from __future__ import annotations

import operator
from collections.abc import Callable, Hashable, Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from planner.base.errors import OptionError
from planner.base.files import make_folder, write_whole
from planner.base.progress import Progress
from planner.batch.results import Results, ResultsFile, measure_missing
from planner.problem.request import SERIAL, PlanRequest, WorkersRequest
from planner.processes import source
from planner.processes.parallel import Measure
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
    isolated: bool = False,
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
        ledger, cases, lambda case: cached(ledger, case), measure, stage, progress, workers, isolated
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
    return source.software(_HERE)
