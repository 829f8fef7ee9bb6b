"""The frame of every benchmark: measure the missing rows, write one report, return an exit code."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from benchmarks.results import ResultsFile, Row
from benchmarks.text import markdown_table, percentile
from planner.base import resources
from planner.base.errors import OptionError
from planner.base.files import make_folder, write_whole
from planner.base.progress import Progress
from planner.batch.parallel import measure_cases
from planner.batch.run import CRASHED, TIMED_OUT
from planner.cli.common import Debug, Out
from planner.cli.terminal import run_into, say
from planner.problem.request import SERIAL, LimitsRequest, PlanRequest, WorkersRequest
from reproduce.verdict import Verdict, tally

__all__ = ["SERIAL", "Debug", "Flat", "Folder", "Out", "Row", "Verdict", "Workers", "WorkersRequest", "tally"]

Workers = WorkersRequest

Folder = Annotated[Path, tyro.conf.arg(help="Folder of planning problems."), tyro.conf.Positional]

Flat = tyro.conf.arg(name="")  # the options of a request, without its name before them

Columns = dict[str, Any]
Read = str | Callable[[Any], Any]  # a column of a row, or a value that is computed from a row
Pick = Callable[[Sequence[Any]], Any]  # from rows to one cell of a table

_HERE = Path(__file__).resolve().parent
FALSE_CLAIM = 4  # exit code of a benchmark that finds a false claim


@dataclass(frozen=True)
class Case:
    """``rows`` of settings, and the ``task`` whose measurement gives the other columns of all of them."""

    rows: Sequence[Row]
    task: Any


@dataclass(frozen=True)
class Bench:
    """A benchmark and its report.

    ``tables`` gives the report's lines about the rows; ``aims`` gives the verdicts; ``fault`` gives the fault of one
    row, an empty text where there is none; ``method`` is the docstring of the benchmark. With a ``group`` of rows the
    report also covers rows of other groups that the folder held already. With ``must_hold`` the exit code is 4 where
    an aim is missed.
    """

    name: str
    method: str | None
    tables: Callable[[Sequence[Row]], list[str]]
    aims: Callable[[Sequence[Row]], Sequence[Verdict]] = lambda rows: ()
    fault: Callable[[Row], str] = lambda row: ""
    group: Callable[[Row], Any] | None = None
    must_hold: bool = False

    def report(self, rows: Sequence[Row], complete: bool = True) -> str:
        """Return the report as Markdown."""
        lines = [f"# python -m benchmarks {self.name}", "", *self.tables(rows), ""]
        lines += aim_lines(self.aims(rows))
        lines += ["", *(f"- {text}" for row in rows if (text := self.fault(row))), ""]
        lines += [] if complete else ["Interrupted: the tables lack the cases that were not measured.", ""]
        lines += [*(f"Software: {text}." for text in dict.fromkeys(row.software for row in rows)), ""]
        text = "\n".join([*lines, (self.method or "").strip()]) + "\n"
        while "\n\n\n" in text:
            text = text.replace("\n\n\n", "\n\n")
        return text


def run_bench(
    bench: Bench,
    out: Path,
    cases: Sequence[Case],
    measure: Callable[[Any, Progress], Columns | Sequence[Columns] | None],
    workers: WorkersRequest = SERIAL,
) -> int:
    """Measure the cases that ``<name>.csv`` in ``out`` lacks, write ``<name>.md``, and return the exit code.

    ``measure(task, progress)`` gives the columns of the case's rows, None where it was stopped. Raises
    :class:`OptionError` where there are no cases, :class:`FileError` for an unusable folder or table.
    """
    if not cases:
        raise OptionError(
            f"{bench.name} has nothing to measure: give at least one value to each option that takes several."
        )

    def run(progress: Progress) -> tuple[list[Row], bool, str]:
        make_folder(out)
        ledger = ResultsFile(out / f"{bench.name}.csv", f"python -m benchmarks {bench.name}")
        rows, complete = _measure_missing(ledger, cases, partial(_fill, measure), progress, workers)
        report = bench.report([*rows, *_rows_of_other_groups(bench, ledger.rows, rows)], complete)
        write_whole(out / f"{bench.name}.md", report.encode())
        return rows, complete, report

    rows, complete, report = run_into(out, run)
    say(report)
    if bench.must_hold and any(aim.confirmed < aim.of for aim in bench.aims(rows)):
        return FALSE_CLAIM
    return 0 if complete else 130


def _measure_missing(
    ledger: ResultsFile,
    cases: Sequence[Case],
    measure: Callable[[Case, Progress], list[Row] | None],
    progress: Progress,
    workers: WorkersRequest,
) -> tuple[list[Row], bool]:
    """Return the rows of every case, from the table or measured now, and whether all cases are measured."""
    rows = [[row for settings in case.rows for row in ledger.find(settings)] for case in cases]
    missing = [k for k, case in enumerate(cases) if len(rows[k]) < len(case.rows)]
    done = len(cases) - len(missing)
    progress("cases", done, len(cases))
    for k, measured in measure_cases([cases[k] for k in missing], measure, workers, progress):
        if measured is None:
            if workers.serial:
                break  # stopped; of several at once some may have ended before
            continue
        rows[missing[k]] = measured
        ledger.add(cases[missing[k]].rows, measured)
        done += 1
        progress("cases", done, len(cases))
    return [row for several in rows for row in several], done == len(cases)


def _rows_of_other_groups(bench: Bench, held: Sequence[Row], measured: Sequence[Row]) -> list[Row]:
    """Return the rows of this software in groups without a measured row."""
    if bench.group is None:
        return []
    here, groups = software(), {bench.group(row) for row in measured}
    return [row for row in held if row.software == here and bench.group(row) not in groups]


def _fill(measure: Callable[[Any, Progress], Any], case: Case, progress: Progress) -> list[Row] | None:
    """Return the rows of a case with their measured columns; None where the measurement was stopped."""
    columns = measure(case.task, progress)
    if columns is None or progress.stopped:
        return None
    several = [columns] * len(case.rows) if isinstance(columns, dict) else columns
    return [Row({**row, **each}) for row, each in zip(case.rows, several, strict=True)]


def measure_apart(
    module: str, options: Columns, progress: Progress, time_limit: float | None = None, seconds: str = ""
) -> Any:
    """Return ``module.measure(**options)`` of a process of its own; None where ``progress`` stopped it.

    A process that fails, or runs for more than ``time_limit`` (s), gives the columns ``outcome`` and ``message``.
    ``seconds`` names a column for the seconds of the process.
    """
    begin, stopped, late = time.perf_counter(), False, False
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "columns.json"
        command = [sys.executable, "-m", "benchmarks.bench", str(out), module, json.dumps(options)]
        with subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
        ) as process:
            while True:
                try:
                    lines = process.communicate(timeout=0.1)[1].decode(errors="replace").strip().splitlines()
                    break
                except subprocess.TimeoutExpired:
                    late = time_limit is not None and time.perf_counter() - begin > time_limit
                    if late or progress.stopped:
                        process.kill()
                        stopped = True
        took = time.perf_counter() - begin
        if late:
            columns = {"outcome": TIMED_OUT, "message": f"killed after {time_limit:g} s; raise --time-limit."}
        elif stopped:
            return None
        elif process.returncode:
            message = f"the process ended with code {process.returncode}: {lines[-1] if lines else ''}"
            columns = {"outcome": CRASHED, "message": message}
        else:
            columns = json.loads(out.read_text())
    return columns | {seconds: took} if seconds else columns


def main(out: str, module: str, options: str) -> None:
    """Measure in this process, and write the columns."""
    importlib.import_module("scipy.sparse.csgraph")  # before a clock starts
    columns = importlib.import_module(module).measure(**json.loads(options))
    write_whole(Path(out), json.dumps(columns, allow_nan=False).encode())


def require_left_to_problems(plain: PlanRequest, *more: str) -> None:
    """Raise :class:`OptionError` for options, and ``more`` of them, that each problem says, or the benchmark itself."""
    given, default = plain.config(), PlanRequest().config()
    for name in ("scene", "request", "start", "goal", "roadmap", *more):
        if given[name] != default[name]:
            raise OptionError(f"{name} is what each problem says: leave it out.")


def plain_limits(limits: LimitsRequest) -> Columns:
    """The limits of a motion as JSON holds them."""
    return {name: value and str(value) if name == "limits" else value for name, value in vars(limits).items()}


def make_settings(names: str, *values: Any) -> Row:
    """Return a row that holds settings by their ``names``, and the software that measures it."""
    return Row(zip(names.split(), values, strict=True), software=software())


def aim_lines(aims: Iterable[Verdict]) -> list[str]:
    """A line for each aim that there was something to judge by."""
    return [f"- {aim.confirmed} of {aim.of}: {aim.sentence} {aim.note}".rstrip() for aim in aims if aim.of]


def values(rows: Iterable[Any], read: Read) -> list[Any]:
    """The values of a column that are there."""
    found = (getattr(row, read) if isinstance(read, str) else read(row) for row in rows)
    return [value for value in found if value is not None]


def middle(read: Read, factor: float = 1.0, share: float = 50.0) -> Pick:
    """The median of a column, or the percentile ``share``, times ``factor``."""

    def pick(rows: Sequence[Any]) -> float | None:
        value = percentile(values(rows, read), share)
        return None if value is None else factor * value

    return pick


def most(read: Read) -> Pick:
    """The largest value of a column."""
    return lambda rows: max(values(rows, read), default=None)


def total(read: Read) -> Pick:
    """The sum of a column; of truth values how many are true."""
    return lambda rows: sum(values(rows, read))


def table(rows: Sequence[Any], by: Sequence[str], columns: dict[str, Pick], whole: bool = False) -> list[str]:
    """A Markdown table: a line for each group of rows that agree in the columns ``by``, and one for the ``whole``."""
    groups: dict[tuple[Any, ...], list[Any]] = {}
    for row in rows:
        groups.setdefault(tuple(getattr(row, name) for name in by), []).append(row)
    lines = [[*group, *(pick(some) for pick in columns.values())] for group, some in groups.items()]
    if whole and rows:
        lines.append(["all", *[""] * (len(by) - 1), *(pick(rows) for pick in columns.values())])
    header = [*(name.replace("_", " ") for name in by), *columns]
    return [*markdown_table(header, lines, texts=len(by)), ""] if lines else []


def row_table(rows: Iterable[Any], texts: Sequence[str], names: Sequence[str]) -> list[str]:
    """A Markdown table with a line for each row: columns of ``texts``, then of numbers."""
    lines = [[getattr(row, name) for name in (*texts, *names)] for row in rows]
    header = [
        name.replace("_m", " (m)") if name.endswith("_m") else name.replace("_", " ") for name in (*texts, *names)
    ]
    return [*markdown_table(header, lines, texts=len(texts)), ""] if lines else []


def ratio(value: float | None, base: float | None) -> float | None:
    """``value`` over ``base``; None where one of them is missing."""
    return None if value is None or not base else value / base


def at_most(sentence: str, value: float | None, limit: float | None) -> Verdict:
    """Return the verdict on a value with a limit; it is about no case where one of them is None."""
    if value is None or limit is None:
        return tally(sentence, [], "")
    return tally(sentence, [value <= limit], f"It is {value:.3g}, {limit:.3g} at most.")


def growth_exponent(points: Iterable[tuple[float, float | None]]) -> float | None:
    """The least-squares slope of log(seconds) against log(size) over (size, seconds); None for fewer than two sizes."""
    size, seconds = np.log(np.array([p for p in points if p[1]], dtype=float).reshape(-1, 2)).T
    return float(np.polyfit(size, seconds, 1)[0]) if len(np.unique(size)) > 1 else None


@cache
def software() -> str:
    """Which software measured a row: versions, the source of the planner and of the benchmarks, the kind of machine."""
    return resources.software(_HERE)


if __name__ == "__main__":
    main(*sys.argv[1:])
