"""A measurement in a process of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.base.progress import Progress
from planner.processes.process import run_case, run_module


def test_a_process_ends_by_itself_is_stopped_or_is_killed_over_time(tmp_path: Path) -> None:
    done = run_module("timeit", ["-n", "1", "-r", "1", "pass"])
    assert (done.code, done.over_time) == (0, False)
    bad = run_module("timeit", ["-n", "1", "-r", "1", "raise ValueError('so it goes')"])
    assert bad.code == 1
    assert bad.last_words == "ValueError: so it goes"
    slow = ["-n", "1", "-r", "1", "import time; time.sleep(60)"]
    late = run_module("timeit", slow, time_limit=0.5)
    assert (late.code, late.over_time) == (None, True)
    assert 0.5 <= late.seconds < 20.0
    stopped = run_module("timeit", slow, progress=Progress(stop=lambda: True))
    assert (stopped.code, stopped.over_time) == (None, False)


def test_a_case_is_told_json_and_answers_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "twice.py").write_text(
        "import json, sys\nwith open(sys.argv[1], 'w') as out: json.dump([2 * json.loads(sys.argv[2])['x']], out)\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    ended, found = run_case("twice", {"x": 4})
    assert (ended.code, found) == (0, [8])
    ended, found = run_case("twice", {})
    assert found is None
    assert ended.fault == "the process ended with code 1: KeyError: 'x'"
