"""Tables as text, and middles of columns with gaps."""

from __future__ import annotations

from planner.base.tables import markdown_table, median, percentile, text_table


def test_tables_and_middles() -> None:
    lines = markdown_table(["what", "n"], [["a|b", 0.12345], ["c\nd", None]])
    assert lines == ["| what | n |", "| :--- | ---: |", "| a\\|b | 0.123 |", "| c d | - |"]
    assert median([3.0, None, 1.0, 2.0]) == 2.0
    assert median([None]) is None
    assert percentile(range(101), 95.0) == 95.0


def test_a_terminals_table_has_dashes_and_five_digits() -> None:
    assert text_table([{"a": 0.123456, "b": None}, {"a": 2, "b": "x"}]) == (["a", "b"], [["0.12346", "-"], ["2", "x"]])
    assert text_table([]) == ([], [])
