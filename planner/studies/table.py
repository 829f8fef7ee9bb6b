"""Rows of a benchmark: a flat CSV file that grows row by row, is read again when a run goes on, and tables of it."""

from __future__ import annotations

import csv
import io
import operator
import platform
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from types import NoneType
from typing import Any, Generic, TypeVar, get_args, get_type_hints

import numpy as np

from planner.base.errors import FileError, OptionError
from planner.base.files import make_folder, write_whole
from planner.base.progress import Progress
from planner.base.request import SERIAL, WorkersRequest
from planner.studies.parallel import Measure, measured_cases
from planner.studies.report import Verdict
from planner.studies.source import source_hash

C = TypeVar("C")
R = TypeVar("R")
"""A frozen dataclass whose fields are texts, numbers, truth values, or None where there is no value."""


@dataclass(frozen=True)
class Bench(Generic[R]):
    """The rows that a benchmark was asked for, and its report, Markdown; ``complete``: it was not interrupted."""

    rows: tuple[R, ...]
    report: str
    complete: bool


class ResultsFile(Generic[R]):
    """The rows that a folder's CSV file holds; each is written as soon as it is there.

    ledger = ResultsFile(folder / "gabf.csv", Row, "planner bench gabf", key=lambda row: (row.nodes, row.software))
    ledger.find(key) or ledger.add(measure())

    ``key`` tells what was measured: new rows take the place of those with their key. ``order`` sorts the file.
    Raises :class:`FileError` where the file is not one that ``command`` wrote.
    """

    def __init__(
        self,
        path: Path,
        kind: type[R],
        command: str,
        key: Callable[[R], Hashable],
        order: Callable[[R], Any] | None = None,
    ) -> None:
        self._path, self._kind, self._key, self._order = path, kind, key, order
        self.rows = read_rows(path, kind, command)

    def find(self, key: Hashable) -> list[R]:
        """The rows measured under ``key``, none where there are none."""
        return [row for row in self.rows if self._key(row) == key]

    def add(self, rows: Sequence[R]) -> None:
        """Keep ``rows`` in the place of those with their keys, and write the file whole."""
        keys = {self._key(row) for row in rows}
        self.rows = [row for row in self.rows if self._key(row) not in keys] + list(rows)
        if self._order is not None:
            self.rows.sort(key=self._order)
        write_whole(self._path, to_csv(self.rows, self._kind).encode())


def measure_missing(
    ledger: ResultsFile[R],
    cases: Sequence[C],
    cached: Callable[[C], list[R]],
    measure: Measure[C, list[R] | None],
    stage: str,
    progress: Progress,
    workers: WorkersRequest = SERIAL,
    isolated: bool = False,
) -> tuple[list[R], bool]:
    """The rows of every case, and whether that is all: those that ``cached`` finds in the ledger, else measured now.

    What is measured is written at once. ``measure`` gives no row where it was stopped. ``progress`` is called with
    (``stage``, done, total); ``workers`` and ``isolated`` as in :func:`planner.studies.parallel.measured_cases`.
    """
    rows = [cached(case) for case in cases]
    missing = [k for k, found in enumerate(rows) if not found]
    done = len(cases) - len(missing)
    progress(stage, done, len(cases))
    for k, found in measured_cases([cases[k] for k in missing], measure, workers, progress, isolated):
        if not found:
            if workers.serial:
                break  # stopped; of several at once some may have ended by then
            continue
        ledger.add(found)
        rows[missing[k]] = found
        done += 1
        progress(stage, done, len(cases))
    return [row for found in rows for row in found], done == len(cases)


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
) -> Bench[R]:
    """:func:`measure_missing` on ``<name>.csv`` of ``folder``, and its rows' report written to ``<name>.md`` beside.

    ``kind`` has a ``key``, what was asked. :class:`OptionError` where there are no cases, :class:`FileError` where the
    folder or the table cannot be used.
    """
    if not cases:
        raise OptionError(f"no {stage} to measure: give at least one value to each option that takes several.")
    make_folder(folder)
    key: Callable[[Any], Hashable] = operator.attrgetter("key")
    ledger = ResultsFile(folder / f"{name}.csv", kind, f"planner bench {name}", key, order)
    rows, complete = measure_missing(
        ledger, cases, lambda case: cached(ledger, case), measure, stage, progress, workers, isolated
    )
    report = to_markdown(rows, complete)
    write_whole(folder / f"{name}.md", report.encode())
    return Bench(tuple(rows), report, complete)


def read_rows(path: Path, kind: type[R], command: str) -> list[R]:
    """The rows of an earlier run, none where there is no file; :class:`FileError` where it is not such a file."""
    if not path.exists():
        return []
    hints = get_type_hints(kind)
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return [
                kind(**{name: _value(line[name], hint) for name, hint in hints.items()})
                for line in csv.DictReader(file)
            ]
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as error:
        raise FileError(f"{path} is not a table that {command} wrote ({error}); move it away.") from None


def to_csv(rows: Iterable[Any], kind: type) -> str:
    """The flat table, one line per row; empty where there is no value."""
    text = io.StringIO()
    table = csv.DictWriter(text, [field.name for field in fields(kind)], lineterminator="\n")
    table.writeheader()
    table.writerows(asdict(row) for row in rows)
    return text.getvalue()


def markdown_table(header: Sequence[str], lines: Iterable[Sequence[Any]], texts: int = 1) -> list[str]:
    """Lines of a Markdown table; the first ``texts`` columns are texts, the others numbers, to three digits."""
    rule = [":---" if k < texts else "---:" for k in range(len(header))]
    rows = [[_cell(value) for value in line] for line in lines]
    return ["| " + " | ".join(row) + " |" for row in (header, rule, *rows)]


def closing_lines(rows: Iterable[Any], complete: bool, missing: str, method: str) -> list[str]:
    """How a report ends: what is missing where it was interrupted, the software of the rows, how it was measured."""
    lines = [] if complete else ["", f"Interrupted: the {missing} that were not measured are missing above."]
    return [*lines, "", *(f"Software: {text}." for text in dict.fromkeys(row.software for row in rows)), "", method]


def aim_lines(aims: Iterable[Verdict]) -> list[str]:
    """A line for each aim that there was something to judge by."""
    return [f"- {aim.confirmed} of {aim.of}: {aim.sentence} {aim.note}".rstrip() for aim in aims if aim.of]


def median(values: Iterable[float | None]) -> float | None:
    """The median of the values that there are; None where there are none."""
    return percentile(values, 50.0)


def percentile(values: Iterable[float | None], share: float) -> float | None:
    """The percentile (linear between two values) of the values that there are; None where there are none."""
    there = [value for value in values if value is not None]
    return float(np.percentile(there, share)) if there else None


def growth_exponent(points: Iterable[tuple[float, float]]) -> float | None:
    """The least-squares slope of log(seconds) against log(size) over (size, seconds); None for fewer than two sizes."""
    size, seconds = np.log(np.array(list(points), dtype=float).reshape(-1, 2)).T
    return float(np.polyfit(size, seconds, 1)[0]) if len(np.unique(size)) > 1 else None


def software(versions: Mapping[str, str]) -> str:
    """Which software measured a row: versions, the source of this package, the kind of machine."""
    named = ", ".join(f"{name} {version}" for name, version in versions.items())
    return f"{named}, source {source_hash()} on {platform.machine()}"


def _value(text: str, hint: Any) -> Any:
    kinds = get_args(hint) or (hint,)
    if text == "" and NoneType in kinds:
        return None
    kind = next(kind for kind in kinds if kind is not NoneType)
    return {"True": True, "False": False}[text] if kind is bool else kind(text)


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value).replace("|", "\\|").replace("\n", " ")
