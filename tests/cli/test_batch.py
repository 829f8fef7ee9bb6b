"""``planner batch`` as its users type it."""

from __future__ import annotations

from pathlib import Path

from tests.batch.test_run import PLANS
from tests.command_line import Run


def test_the_command_ends_with_4_where_some_are_not_solved(tmp_path: Path, run: Run) -> None:
    source = tmp_path / "batch.yaml"
    source.write_text(PLANS)
    options = ("--robot", "planar_2r", "--scene", "empty", "--nodes", "20", "--pages")
    code, out, _ = run("batch", str(source), *options, "--out", str(tmp_path / "out"))
    assert code == 4
    assert "2 of 3 solved" in out
    assert (tmp_path / "out" / "one" / "plan.html").is_file()
