"""The command line as the tests run it, and the form of a refusal."""

import re
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout, suppress
from functools import cache
from io import StringIO
from pathlib import Path

from planner.cli import app

Run = Callable[..., tuple[int, str, str]]


def command(*arguments: str, cwd: Path, program: str = "planner", **more: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", program, *arguments],
        cwd=cwd,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        **more,
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


def assert_total_covers(timings: Mapping[str, float], stages: set[str]) -> None:
    """``total`` is of the whole command: no less than all ``stages``, which are all that there are."""
    parts = {stage: seconds for stage, seconds in timings.items() if stage != "total"}
    assert set(parts) == stages
    assert sum(parts.values()) <= timings["total"] + 1e-5


def assert_remedies_are_options(arguments: Sequence[str], text: str) -> None:
    """A command names none but its own ``--options``; of other commands only where it quotes them whole."""
    sentence = " ".join(line for line in text.splitlines() if line.startswith("planner: "))
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", re.sub(r"'planner [^']*'", "", sentence)))
    if not named:
        return
    own = _options(tuple(arguments[: 2 if arguments[:1] in (["roadmap"], ("roadmap",)) else 1]))
    assert named - set(arguments) <= own, f"{arguments[0]} has no {named - own}: {sentence}"


@cache
def _options(command: tuple[str, ...]) -> frozenset[str]:
    """The options that the help of a command tells of."""
    text = StringIO()
    with redirect_stdout(text), suppress(SystemExit):
        app.run([*command, "--help"])
    return frozenset(re.findall(r"(?<![\w-])--[a-z][a-z-]*", text.getvalue()))
