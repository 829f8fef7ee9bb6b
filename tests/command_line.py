"""The command line as the tests run it, and what a refusal must look like."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

Run = Callable[..., tuple[int, str, str]]


def command(*arguments: str, cwd: Path, program: str = "planner", **more: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", program, *arguments],
        cwd=cwd,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        **more,  # type: ignore[call-overload]
    )


def assert_refused(result: tuple[int, str, str], code: int, text: str, out: Path) -> None:
    got, output, error = result
    assert got == code, error
    assert text.lower() in " ".join(error.replace("│", " ").split()).lower()
    assert "Traceback" not in error + output
    assert not out.exists(), "a refused command writes nothing"
    if code == 3:
        assert error.count("planner: error: ") == 1
        assert error.rstrip().endswith(".")
