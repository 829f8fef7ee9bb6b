"""Rows of a benchmark: a flat CSV file that grows row by row and is read again when a run continues."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from planner.base.errors import FileError
from planner.base.files import write_whole


class Row(dict[str, Any]):
    """One line of a table: text, numbers and truth values by column. ``row.name`` is None without such a column."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self.get(name)


class ResultsFile:
    """The rows in a CSV file; new rows are written as soon as they are measured.

    ledger = ResultsFile(folder / "gabf.csv", "python -m benchmarks gabf")
    ledger.find(settings) or ledger.add([settings], [measure(settings)])

    Raises :class:`FileError` where another program wrote the file.
    """

    def __init__(self, path: Path, command: str) -> None:
        self._path, self.rows = path, read_rows(path, command)

    def find(self, settings: Row) -> list[Row]:
        """Return the rows that hold these ``settings``."""
        return [row for row in self.rows if settings.items() <= row.items()]

    def add(self, settings: Sequence[Row], rows: Sequence[Row]) -> None:
        """Replace the rows with any of these ``settings`` by ``rows``, and write the whole file."""
        others = [row for row in self.rows if not any(each.items() <= row.items() for each in settings)]
        self.rows = [*others, *rows]
        write_whole(self._path, to_csv(self.rows).encode())


def read_rows(path: Path, command: str) -> list[Row]:
    """Return the rows of an earlier run, none where there is no file; raise :class:`FileError` for any other file."""
    if not path.exists():
        return []
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = list(csv.DictReader(file))
        rows = [
            Row({name: value for name, cell in line.items() if (value := _value(cell)) is not None}) for line in lines
        ]
        if any(None in line or "software" not in line for line in lines):
            raise ValueError("no column 'software'")
        return rows
    except (OSError, ValueError, TypeError, csv.Error) as error:
        raise FileError(f"{path} must be a table of {command}, got another file ({error}): move it away.") from None


def to_csv(rows: Iterable[Row]) -> str:
    """Return the table as CSV text, a line per row; a cell is empty where a row has no value."""
    text, rows = io.StringIO(), list(rows)
    table = csv.writer(text, lineterminator="\n")
    names = list(dict.fromkeys(name for row in rows for name in row))
    table.writerow(names)
    table.writerows([_cell(row.get(name)) for name in names] for row in rows)
    return text.getvalue()


def _cell(value: Any) -> str:
    """Return the text of a value; text that reads as something else is quoted."""
    if isinstance(value, str):
        return value if value[:1] not in ("", '"') and _value(value) == value else json.dumps(value)
    return "" if value is None else repr(getattr(value, "item", lambda: value)())


def _value(cell: str) -> Any:
    if cell in ("", "True", "False"):
        return {"": None, "True": True, "False": False}[cell]
    for kind in (int, float):
        try:
            return kind(cell)
        except ValueError:
            continue
    return json.loads(cell) if cell.startswith('"') else cell
