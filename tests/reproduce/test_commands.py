"""``python -m reproduce`` as its users type it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from reproduce import commands
from reproduce.laws.run import run_laws
from reproduce.report import Report


def test_a_simulation_prints_its_verdicts_and_writes_its_files(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "reproduce", "example", "--out", str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    record = json.loads((tmp_path / "out" / "example.json").read_text())
    for verdict in record["verdicts"]:
        assert f"{verdict['confirmed']} of {verdict['of']}" in done.stdout
    assert "P(4) = {2, 3}." in done.stdout
    assert max(map(len, done.stdout.splitlines()[:-1])) <= 80, "the last line names the files"
    wrong = subprocess.run([*command, "--seed", "-1"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2
    assert wrong.stderr.startswith("planner: error: seed")
    assert wrong.stderr.count("\n") == 1


def test_wide_tables_stay_in_the_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    report = run_laws(graphs=1, nodes=60)
    part = Report("laws", {}, report.table, report.verdicts, complete=False)
    assert commands.reproduce(tmp_path, 0, lambda _: part) == 130
    out = capsys.readouterr().out
    assert "…" not in out, "a table that does not fit"
    assert "Larger h leads to" in out
    assert len(json.loads((tmp_path / "laws.json").read_text())["table"]) == len(report.table)
