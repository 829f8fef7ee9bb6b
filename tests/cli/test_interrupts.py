"""Ctrl-C at any moment ends the process with a sentence and loses no finished result."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from planner.cli.common import choose_file, choose_folder

LIMIT = 30  # s: machines that run tests are busy

# Python itself takes a while before any of our lines is read: signals are sent from there on
_ANNOUNCED = """
import planner.__main__ as program
program.leave_on_interrupt()
print("ready", flush=True)
program.main()
"""


def started(*arguments: str, cwd: Path) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", _ANNOUNCED, *arguments],
        cwd=cwd,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout.readline() == "ready\n"
    return process


def interrupted(process: subprocess.Popen[str]) -> str:
    """Standard error of a process that ends as one does on Ctrl-C."""
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=LIMIT)
    assert time.monotonic() - begin < LIMIT
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert "Exception ignored" not in err
    assert "planner: stopping" in err
    return err


@pytest.mark.parametrize("after", [0.0, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5])
def test_the_first_half_second(tmp_path: Path, after: float) -> None:
    process = started("plan", "--nodes", "20000", "--out", "o", cwd=tmp_path)
    time.sleep(after)
    interrupted(process)


@pytest.mark.parametrize("command_name", ["robots", "view"])
def test_commands_with_nothing_to_save(tmp_path: Path, command_name: str) -> None:
    err = interrupted(started(command_name, cwd=tmp_path))
    assert "there is nothing to save" in err
    assert not list(tmp_path.iterdir())


def test_no_result_is_overwritten_by_an_interrupted_one(tmp_path: Path) -> None:
    names = ("plan.json", "plan.html", "roadmap.npz")
    assert choose_folder(tmp_path / "new", names) == tmp_path / "new"
    assert choose_folder(tmp_path, names) == tmp_path
    (tmp_path / "roadmap.npz").touch()  # perhaps of hours of work
    for name in ("interrupted", "interrupted-2", "interrupted-3"):
        assert choose_folder(tmp_path, names) == tmp_path / name
        (tmp_path / name).mkdir()
        (tmp_path / name / "plan.json").touch()
    assert choose_file(tmp_path / "roadmap.npz") == tmp_path / "roadmap.interrupted.npz"
    assert choose_file(tmp_path / "none.npz") == tmp_path / "none.npz"
