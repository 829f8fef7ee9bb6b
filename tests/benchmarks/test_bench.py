"""What the benchmarks share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from benchmarks.bench import run_bench, software
from planner.base import versions
from planner.base.errors import OptionError
from planner.base.progress import Progress


@dataclass(frozen=True)
class Row:
    name: str


def test_nothing_to_measure_is_told_and_writes_nothing(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="no plans to measure"):
        run_bench(tmp_path / "b", "b", Row, [], lambda *_: [], lambda *_: None, lambda *_: "", "plans", Progress())
    assert not (tmp_path / "b").exists()


def test_rows_are_of_the_planners_source_and_the_benchmarks() -> None:
    assert software() != versions.software()
    assert software().split(", source ")[0] == versions.software().split(", source ")[0]
