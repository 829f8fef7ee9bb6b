"""The runner of another environment: it imports nothing of ours, and writes what the planner there says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.motion import runner


def test_it_imports_nothing_of_ours() -> None:
    assert "import planner" not in Path(runner.__file__).read_text()
    assert "from planner" not in Path(runner.__file__).read_text()


def test_a_refusal_is_an_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(problem: dict) -> dict:
        raise RuntimeError(problem["why"])

    monkeypatch.setattr(runner, "time_by_roboplan", refuse)
    monkeypatch.setattr(runner.importlib.metadata, "version", lambda name: "1")
    (tmp_path / "problem.json").write_text('{"why": "too short"}')
    runner.main(str(tmp_path / "problem.json"), str(tmp_path / "answer.json"))
    assert json.loads((tmp_path / "answer.json").read_text()) == {"version": "1", "message": "too short"}
