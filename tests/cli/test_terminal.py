"""Bars of progress on standard error."""

from __future__ import annotations

import pytest

from planner.cli.terminal import watching


def bars(reports: list[tuple[str, int, int]], capsys: pytest.CaptureFixture[str]) -> dict[str, list[str]]:
    """The words after each stage's bar, by its name."""
    with watching() as progress:
        for report in reports:
            progress(*report)
    lines = [line.split() for line in capsys.readouterr().err.splitlines() if line.strip()]
    return {words[0]: [word for word in words[1:] if set(word) - set("━╸╺")] for words in lines}


def test_a_stage_has_one_bar_with_its_unit_however_often_it_begins(capsys: pytest.CaptureFixture[str]) -> None:
    rounds = [("improve", done, total) for total in (3, 1, 1) for done in range(total + 1)]
    shown = bars([("roadmap", 7, 10), *rounds, ("roadmap", 10, 10), ("beta", 100, 100)], capsys)
    assert [words[:2] for words in shown.values()] == [["10/10", "nodes"], ["5/5", "rounds"], ["100/100", "%"]]
    assert all(len(words) == 3 for words in shown.values())  # and the time it took


def test_without_a_known_end_the_bar_counts(capsys: pytest.CaptureFixture[str]) -> None:
    shown = bars([("path", done, 0) for done in range(4)], capsys)
    assert shown["path"][:2] == ["3", "paths"]
