"""The command line's words before they are read."""

from __future__ import annotations

import pytest

from planner.base.errors import OptionError
from planner.cli.arguments import prepared
from planner.problem.targets import AND


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["plan", "--beta", "0"], ["plan", "--beta", "0"]),
        (["--goal", "a", "--seed", "1", "--goal=b"], ["--goal", f"a{AND}b", "--seed", "1"]),
        (["--goal=a", "--goal", "q:-1,2"], ["--goal", f"a{AND}q:-1,2"]),
        (["--goal"], ["--goal"]),  # the parser says what is missing
    ],
)
def test_goals_become_one(words: list[str], expected: list[str]) -> None:
    assert prepared(words) == expected


@pytest.mark.parametrize(
    ("words", "what"),
    [(["plan", "--out="], "--out"), (["plan", "--out", "", "--view"], "--out"), (["batch", ""], "a word")],
)
def test_an_empty_word_is_refused(words: list[str], what: str) -> None:
    """An empty folder would be the one that the shell stands in."""
    with pytest.raises(OptionError, match=f"{what} is empty"):
        prepared(words)


@pytest.mark.parametrize("second", ["--ik-solutions=4", "--ik_solutions"])
def test_any_other_option_stands_once(second: str) -> None:
    with pytest.raises(OptionError, match="--ik-solutions is given twice"):
        prepared(["plan", "--ik-solutions", "3", second, "4"])
