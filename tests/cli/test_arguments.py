"""The command line's words before they are read."""

from __future__ import annotations

import pytest

from planner.base.errors import OptionError
from planner.cli.app import prepared
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
    ("words", "said"),
    [
        (["plan", "--out="], "--out is empty"),  # it would be the folder that the shell stands in
        (["batch", ""], "a word is empty"),
        (["plan", "--ik-solutions", "3", "--ik_solutions", "4"], "--ik-solutions is given twice"),
    ],
)
def test_empty_words_and_options_given_twice_are_refused(words: list[str], said: str) -> None:
    with pytest.raises(OptionError, match=said):
        prepared(words)
