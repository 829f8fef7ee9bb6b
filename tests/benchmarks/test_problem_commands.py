"""``benchmarks plan`` as its users type it: a folder of problems, resumed, interrupted."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import pytest

from benchmarks.plan.rows import Row
from benchmarks.results import read_rows
from tests.batch.posts import write_problem
from tests.command_line import Run, command

PLANAR = ("--robot", "planar_2r", "--collision", "coal", "--nodes", "30", "--seeds", "0")


def test_a_problem_without_its_scene_is_a_refused_row(tmp_path: Path, run: Run) -> None:
    write_problem(tmp_path / "p", "0001", (-1.0, 0.8), (1.0, -0.8))
    write_problem(tmp_path / "p", "0002", (-1.0, 0.8), (1.0, -0.8))
    (tmp_path / "p" / "scene0002.yaml").unlink()
    code, text, _ = run("plan", str(tmp_path / "p"), *PLANAR, "--out", str(tmp_path / "o"), program="benchmarks")
    assert code == 0
    assert "| p | 2 | 1 | 1 | 100 % |" in text
    rows = read_rows(tmp_path / "o" / "plan.csv", Row, "python -m benchmarks plan")
    assert [row.outcome for row in rows] == ["solved", "refused"]
    assert "scene0002.yaml" in rows[1].message
    assert text.strip() == (tmp_path / "o" / "plan.md").read_text().strip()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_saves_and_the_rest_follows_later(tmp_path: Path, run: Run, number: int) -> None:
    write_problem(tmp_path / "p", "0001", (-1.0, 0.8), (1.0, -0.8))
    write_problem(tmp_path / "p", "0002", (-1.0, 0.8), (1.0, -0.8))
    arguments = ("plan", "p", *PLANAR, "--out", "o", "--time-limit", "1000")
    process = command(*arguments, cwd=tmp_path, program="benchmarks")
    until = time.monotonic() + 120
    while not (tmp_path / "o" / "plan.csv").exists():
        assert time.monotonic() < until
        assert process.poll() is None
        time.sleep(0.01)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    process.send_signal(number)
    text, error = process.communicate(timeout=60)
    assert not [child for child in children if Path(f"/proc/{child}/exe").exists()]
    assert "Traceback" not in error
    assert process.returncode == 130
    assert "Interrupted" in text
    rows = read_rows(tmp_path / "o" / "plan.csv", Row, "python -m benchmarks plan")
    assert [row.problem for row in rows] == ["p/0001"]
    code, text, _ = run(
        "plan", str(tmp_path / "p"), *PLANAR, "--out", str(tmp_path / "o"), "--time-limit", "1000", program="benchmarks"
    )
    assert code == 0
    again = read_rows(tmp_path / "o" / "plan.csv", Row, "python -m benchmarks plan")
    assert rows[0] in again
    assert {row.problem for row in again} == {"p/0001", "p/0002"}
