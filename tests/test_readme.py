"""The README is short, and its code and commands run as they stand."""

import re
from pathlib import Path

import pytest

from tests.command_line import Run
from tests.documents import ROOT, assert_options_are_known, assert_they_run, blocks, commands

README = (ROOT / "README.md").read_text()
COMMANDS = commands([line for line in README.splitlines() if line.startswith("    ")])


def test_the_library_example_prints_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (example,) = blocks(README, "python")
    exec(example, {})
    results = re.findall(r"print\(.*\)  # (.*)", example)
    for line, result in zip(capsys.readouterr().out.splitlines(), results, strict=True):
        assert result.startswith(line)
    assert {path.name for path in Path("out").iterdir()} == {"plan.json", "plan.html", "roadmap.npz", "trajectory.json"}


def test_the_commands_run_as_they_stand(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(COMMANDS) == 4
    for words in COMMANDS:
        assert_options_are_known(words, run)
    assert_they_run(COMMANDS, run, tmp_path, monkeypatch)


def test_a_reader_sees_purpose_picture_example_reasons_and_installation_in_80_lines() -> None:
    parts = ("plan.webp", "```python", "    planner plan", "## Why", "## Install", "## Where", "## What it does not do")
    places = [README.index(part) for part in (*parts, "CITATION.cff")]
    assert places == sorted(places)
    assert README.count("\n") <= 80


def test_files_that_the_readme_links_exist() -> None:
    for name in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / name).is_file(), name
