"""A full disk, too little memory and names that the system refuses end in one sentence, not in a traceback."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]

ENDS = {
    "no memory": (MemoryError(), 3, "memory does not suffice"),
    "a library": (ImportError("libx.so: failed to map segment"), 3, "a library cannot be loaded (libx.so"),
    "no thread": (RuntimeError("can't start new thread"), 3, "memory does not suffice"),
    "a full disk": (OSError(errno.ENOSPC, "No space left on device"), 3, "No space left on device; make room"),
    "nobody reads": (BrokenPipeError(), 0, ""),
}


@pytest.mark.parametrize("name", ENDS)
def test_what_the_system_refuses(name: str, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    error, code, part = ENDS[name]

    def refuse(_: list[str]) -> int:
        raise error

    monkeypatch.setattr("planner.cli.app.run", refuse)
    got, out, err = run("robots")
    assert (got, out) == (code, "")
    assert part in err
    assert len(err.splitlines()) == bool(part)


def test_a_bug_is_no_system(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: list[str]) -> int:
        raise RuntimeError("a bug")

    monkeypatch.setattr("planner.cli.app.run", refuse)
    with pytest.raises(RuntimeError, match="a bug"):
        run("robots")


def _planner(*arguments: str, stdout: int) -> tuple[int, str]:
    command = [sys.executable, "-m", "planner", *arguments]
    done = subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, text=True, check=False)
    return done.returncode, done.stderr


def test_a_full_disk_behind_standard_output() -> None:
    full = os.open("/dev/full", os.O_WRONLY)
    code, err = _planner("robots", stdout=full)
    os.close(full)
    assert code == 3
    assert err.splitlines() == [
        "planner: error: the system refused: No space left on device; make room or choose another place."
    ]


LONG = "x" * 300


@pytest.mark.parametrize(
    "words",
    [
        ["plan", "--out", LONG],
        ["plan", "--out", "/dev/full"],
        ["plan", "--roadmap", LONG],
        ["plan", "--scene", LONG],
        ["plan", "--robot", f"{LONG}.urdf"],
        ["plan", "--request", LONG],
        ["view", LONG],
        ["view", "/dev/full"],
        ["roadmap", "info", LONG],
        ["roadmap", "build", LONG],
        ["roadmap", "build", "/dev/full"],
        ["check", f"{LONG}.json"],
        ["sweep", "--out", LONG],
    ],
    ids=lambda words: " ".join(words).replace(LONG, "LONG"),
)
def test_names_that_cannot_be_used(words: list[str], run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, err = run(*words)
    assert code == 3, err
    assert err.count("planner: error: ") == 1
    assert len([line for line in err.splitlines() if line]) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("option", "value"), [("--prescribed-time", "1e308"), ("--margin", "1e300"), ("--min-manipulability", "1e300")]
)
def test_numbers_out_of_range(option: str, value: str, run: Run, tmp_path: Path) -> None:
    code, _, err = run("plan", option, value, "--out", str(tmp_path / "out"))
    assert code == 2
    assert "not usable" in " ".join(err.split())
    assert not (tmp_path / "out").exists()
