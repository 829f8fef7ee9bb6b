"""A function called in a process of its own: its answer, its errors, a process that is killed, and a stop."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest

from planner.base.errors import OptionError, PlannerError
from planner.base.progress import QUIET, Progress
from planner.processes.apart import call_apart
from tests.processes.functions import killed_always, killed_at_first, process_id, refused, square


def test_the_answer_comes_from_another_process_and_no_file_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert call_apart(process_id, 0, QUIET) != os.getpid()
    assert not list(tmp_path.iterdir())


def test_errors_of_the_planner_come_back_as_they_were() -> None:
    with pytest.raises(OptionError, match="7 is refused: give another number"):
        call_apart(refused, 7, QUIET)


def test_any_other_error_is_one_sentence_with_its_last_words() -> None:
    with pytest.raises(PlannerError, match=r"ended with code 1: TypeError: .*'str'.*\.$"):
        call_apart(square, "three", QUIET)


def test_a_process_that_is_killed_is_started_once_more(tmp_path: Path) -> None:
    assert call_apart(killed_at_first, tmp_path / "mark", QUIET) == "mark"
    with pytest.raises(PlannerError, match=r"ended with code -9: it was killed\.$"):
        call_apart(killed_always, 0, QUIET)


def test_a_stop_leaves_no_answer(tmp_path: Path) -> None:
    assert call_apart(killed_at_first, tmp_path / "mark", Progress(stop=lambda: True)) is None
