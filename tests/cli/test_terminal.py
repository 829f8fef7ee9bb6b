"""What the terminal shows: one printable line for errors, a bar per stage."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from planner.base.errors import FileError
from planner.base.progress import Progress
from planner.cli.terminal import (
    complain,
    facts,
    report_table,
    run_into,
    say,
    show,
    watching,
    working,
)


def test_complaints_stay_on_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    complain("file 'a\nb\x1b[2J' not found")
    assert capsys.readouterr().err == "planner: file 'a\\nb\\x1b[2J' not found\n"


def test_names_that_are_no_text_are_said_all_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    say("scene\udcff.yaml")
    assert capsys.readouterr().out == "scene\\udcff.yaml\n"


def test_no_name_steers_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    name = "box\x1b]0;title\x07\x9b2J\u202e"
    say(f"{name}\nrow")
    show(facts(name, [(name, f"near {name}")]))
    show(report_table([{name: name}]))
    out = capsys.readouterr().out
    assert out.count("\\x1b]0;title\\x07\\x9b2J\\u202e") >= 5
    assert not set("\x1b\x07\x9b\u202e") & set(out)


def test_no_name_in_a_warning_steers_the_terminal() -> None:
    script = "import logging, sys; from planner import cli; sys.argv[1:] = ['--version']\n"
    script += "import atexit; atexit.register(lambda: logging.warning('%s: two\\nlines', 'a\\x1b[2Jb'))\ncli.main()"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.stderr == "planner: a\\x1b[2Jb: two\nlines\n"


@pytest.mark.parametrize("context", [working, watching])
def test_each_stage_has_its_bar(context, capsys: pytest.CaptureFixture[str]) -> None:
    with context() as progress:
        progress("roadmap", 1, 4)
        progress("roadmap", 9, 4)  # never beyond its end
        progress("costs", 2, 3)
        assert not progress.stopped
    text = capsys.readouterr().err
    assert "4/4" in text
    assert "2/3" in text


def test_a_folder_that_cannot_be_written_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    worked: list[Progress] = []
    with pytest.raises(FileError, match="cannot be written"):
        run_into(tmp_path / "file" / "in", worked.append)
    assert not worked


def shown(renderable: object) -> str:
    console = Console(width=200)
    with console.capture() as capture:
        console.print(renderable)
    return capture.get()


def test_tables_show_text_as_it_is() -> None:
    table = shown(report_table([{"law": "[bold]nominal", "time": 1.5}]))
    assert "[bold]nominal" in table
    assert "1.5" in table
