"""Rows of a benchmark: a flat CSV file that grows row by row, is read again when a run goes on, and tables of it."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from types import NoneType
from typing import Any, Generic, TypeVar, get_args, get_type_hints

from planner.base.errors import FileError
from planner.base.files import write_whole
from planner.base.progress import Progress
from planner.batch.parallel import Measure, measure_cases
from planner.problem.request import SERIAL, WorkersRequest

C = TypeVar("C")
R = TypeVar("R")
"""A frozen dataclass whose fields are texts, numbers, truth values, or None where there is no value."""


@dataclass(frozen=True)
class Results(Generic[R]):
    """The rows that were asked for, and its report, Markdown; ``complete``: it was not interrupted."""

    rows: tuple[R, ...]
    report: str
    complete: bool


class ResultsFile(Generic[R]):
    """The rows that a folder's CSV file holds; each is written as soon as it is there.

    ledger = ResultsFile(folder / "seeds.csv", Row, "planner sweep --seeds", key=lambda row: (row.seed, row.software))
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
) -> tuple[list[R], bool]:
    """The rows of every case, and whether that is all: those that ``cached`` finds in the ledger, else measured now.

    What is measured is written at once. ``measure`` gives no row where it was stopped. ``progress`` is called with
    (``stage``, done, total); ``workers`` as in :func:`planner.batch.parallel.measure_cases`.
    """
    rows = [cached(case) for case in cases]
    missing = [k for k, found in enumerate(rows) if not found]
    done = len(cases) - len(missing)
    progress(stage, done, len(cases))
    for k, found in measure_cases([cases[k] for k in missing], measure, workers, progress):
        if not found:
            if workers.serial:
                break  # stopped; of several at once some may have ended by then
            continue
        ledger.add(found)
        rows[missing[k]] = found
        done += 1
        progress(stage, done, len(cases))
    return [row for found in rows for row in found], done == len(cases)


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


def _value(text: str, hint: Any) -> Any:
    kinds = get_args(hint) or (hint,)
    if text == "" and NoneType in kinds:
        return None
    kind = next(kind for kind in kinds if kind is not NoneType)
    return {"True": True, "False": False}[text] if kind is bool else kind(text)
