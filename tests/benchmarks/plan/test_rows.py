"""The rows of planned problems."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from benchmarks.plan import run as bench
from benchmarks.plan.rows import by_settings
from benchmarks.problems import find_problems
from tests.batch.posts import PLAIN


def test_options_of_a_plan_tell_rows_apart(problems: Path) -> None:
    problem = find_problems(problems)[1]
    plain = bench._blank(problem, PLAIN, 60.0)
    kept = bench._blank(problem, replace(PLAIN, margin=0.01), 60.0)
    assert plain.options == ""
    assert kept.options == "margin 0.01"
    assert len(by_settings([plain, kept])) == 2
