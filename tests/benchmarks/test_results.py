"""Rows that survive their file, and replace the rows that were measured before."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.results import ResultsFile, Row, read_rows, to_csv
from planner.base.errors import FileError
from tests.random_shapes import QUICK

COMMAND = "python -m benchmarks this"
TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\r\x00")) | st.sampled_from(
    ["1", "1e3", "True", "nan", '"']
)
VALUES = st.booleans() | st.integers() | st.floats(allow_nan=False) | TEXT


@QUICK
@given(st.lists(st.dictionaries(st.sampled_from("abc"), VALUES), min_size=1))
def test_rows_survive_the_file(tmp_path_factory: pytest.TempPathFactory, content: list[dict]) -> None:
    rows, path = [Row(each, software="here") for each in content], tmp_path_factory.mktemp("rows") / "t.csv"
    path.write_bytes(to_csv(rows).encode())
    back = read_rows(path, COMMAND)
    assert back == rows
    assert [[type(value) for value in row.values()] for row in back] == [
        [type(row[name]) for name in again] for row, again in zip(rows, back, strict=True)
    ]


LONG = f"name,software\n{'x' * 140_000},1\n"  # longer than a cell may be


@pytest.mark.parametrize("text", ["a,b\n1,2\n", "\xff\xfe", "software\n1,2\n", LONG])
def test_a_foreign_table_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "t.csv").write_bytes(text.encode("latin-1"))
    with pytest.raises(
        FileError, match=r"must be a table of python -m benchmarks this, got another file.*move it away"
    ):
        ResultsFile(tmp_path / "t.csv", COMMAND)


def test_a_ledger_replaces_what_it_measured_before(tmp_path: Path) -> None:
    first, second = (Row(name=name, software="here") for name in ("a, b", ""))
    ledger = ResultsFile(tmp_path / "t.csv", COMMAND)
    ledger.add([first, second], [Row(first, seconds=1.0), Row(second, work=12)])
    ledger.add([first], [Row(first, seconds=9.0)])
    again = ResultsFile(tmp_path / "t.csv", COMMAND)
    assert again.rows == [Row(second, work=12), Row(first, seconds=9.0)]
    assert again.find(first) == [Row(first, seconds=9.0)]
    assert again.find(Row(name="c", software="here")) == []
    assert again.rows[0].seconds is None
