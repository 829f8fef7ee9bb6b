"""A benchmark as a command: its report, and its exit code."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from benchmarks.terminal import measure


@dataclass
class Made:
    report: str
    complete: bool


@pytest.mark.parametrize(("complete", "code"), [(True, 0), (False, 130)])
def test_a_benchmark_shows_its_report(
    complete: bool, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert measure(tmp_path, lambda _: Made("| a |", complete)) == code
    assert capsys.readouterr().out == "| a |\n"
