"""Rows that survive their file, and take the place of those measured before."""

from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from benchmarks.results import ResultsFile, read_rows, to_csv
from planner.base.errors import FileError


@dataclass(frozen=True)
class Row:
    name: str
    count: int
    seconds: float | None
    work: int | None
    good: bool
    note: str | None = None


ROWS = [
    Row("a, b", 3, 0.1 + 0.2, None, True, 'says "no",\nthen yes'),
    Row("", -1, None, 12, False),
]


def ledger(path: Path) -> ResultsFile[Row]:
    return ResultsFile(
        path, Row, "python -m benchmarks this", key=lambda row: (row.name, row.count), order=lambda row: row.count
    )


def test_rows_survive_the_file(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(to_csv(ROWS, Row))
    assert read_rows(tmp_path / "t.csv", Row, "python -m benchmarks this") == ROWS
    assert read_rows(tmp_path / "missing.csv", Row, "python -m benchmarks this") == []


LONG = f"name,x\n{'x' * 140_000},1\n"  # longer than a cell may be


@pytest.mark.parametrize(
    "text", ["a,b\n1,2\n", to_csv(ROWS, Row).replace("True", "perhaps"), "\xff\xfe", "name\nx\n", LONG]
)
def test_a_foreign_table_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "t.csv").write_bytes(text.encode("latin-1"))
    with pytest.raises(FileError, match=r"is not a table that python -m benchmarks this wrote.*move it away"):
        ledger(tmp_path / "t.csv")


def test_a_ledger_replaces_what_it_measured_before(tmp_path: Path) -> None:
    kept = ledger(tmp_path / "t.csv")
    kept.add(ROWS)
    kept.add([replace(ROWS[0], seconds=9.0)])
    again = ledger(tmp_path / "t.csv")
    assert again.rows == [ROWS[1], replace(ROWS[0], seconds=9.0)]
    assert again.find(("a, b", 3)) == [replace(ROWS[0], seconds=9.0)]
    assert again.find(("a, b", 4)) == []
