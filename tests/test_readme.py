"""What the README says runs as it stands."""

import re
from pathlib import Path

import pytest

from tests.command_line import Run
from tests.documents import ROOT, assert_options_are_known, assert_they_run, blocks, commands

README = (ROOT / "README.md").read_text()
COMMANDS = commands([line for line in README.splitlines() if line.startswith("    ")])


def test_the_library_example_runs(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    (example,) = blocks(README, "python")
    exec(example.replace("beta=0.2,", "beta=0.2, nodes=60,"), names)
    assert len(names["plan"].path) >= 2
    assert names["plan"].trajectory.proven
    written = {"plan.json", "plan.html", "roadmap.npz", "trajectory.json"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == written
    assert run("export", "out", "--format", "ros-json")[0] == 0


def test_the_commands_run_as_they_stand(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(COMMANDS) == 5
    for words in COMMANDS:
        assert_options_are_known(words, run)
    assert_they_run(COMMANDS, run, tmp_path, monkeypatch)


def test_a_reader_sees_what_it_is_and_how_to_try_it_on_the_first_screens() -> None:
    first = README[: README.index("## How it works")]
    seen = ("plan.png", "**What it is for.**", "**Why to trust it.**", "```python", "    planner plan", "## Install")
    places = [first.index(text) for text in seen]
    assert places == sorted(places)
    assert first.count("\n") < 70


def test_what_the_readme_refers_to_is_there() -> None:
    for name in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / name).is_file(), name
