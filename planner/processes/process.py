"""A measurement in a process of its own, in a session of its own, so that Ctrl-C reaches us and not it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from planner.base.progress import QUIET, Progress

_WITH_PARENT = Path(__file__).with_name("with_parent.py")


@dataclass(frozen=True)
class Ended:
    """How a process ended: ``code`` is None where it was killed, because stopped or over its time.

    ``last_words``: the last line it wrote to standard error.
    """

    code: int | None
    seconds: float
    over_time: bool
    last_words: str

    @property
    def fault(self) -> str:
        """What to say of a process that ended by itself and not well."""
        return f"the process ended with code {self.code}: {self.last_words}"


def run_case(
    module: str,
    options: Mapping[str, Any],
    progress: Progress = QUIET,
    time_limit: float | None = None,
    tries: int = 1,
) -> tuple[Ended, Any]:
    """How ``python -m module OUT OPTIONS`` ended, and what it wrote to OUT; None where it did not end well.

    Both are JSON; ``progress``, ``time_limit`` and ``tries`` are those of :func:`run_module`.
    """
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "found.json"
        ended = run_module(module, [str(out), json.dumps(options)], progress, time_limit, tries)
        return ended, json.loads(out.read_text()) if ended.code == 0 else None


def run_module(
    module: str,
    arguments: Sequence[str],
    progress: Progress = QUIET,
    time_limit: float | None = None,
    tries: int = 1,
) -> Ended:
    """Run ``python -m module arguments`` until it ends, ``progress`` is stopped, or ``time_limit`` (s) has passed.

    It ends with this process, also where this one is killed. A process that a signal ends, as a system short of memory
    sends it, is started again, ``tries`` times in all.
    """
    while True:
        ended, tries = _run_once(module, arguments, progress, time_limit), tries - 1
        if ended.code is None or ended.code >= 0 or tries <= 0:
            return ended


def _run_once(module: str, arguments: Sequence[str], progress: Progress, time_limit: float | None) -> Ended:
    begin = time.perf_counter()
    over = False
    with tempfile.TemporaryFile() as errors:  # not a pipe: nobody reads it while the process runs
        command = [sys.executable, "-P", str(_WITH_PARENT), str(os.getpid()), module, *arguments]
        with subprocess.Popen(command, stderr=errors, stdout=subprocess.DEVNULL, start_new_session=True) as process:
            try:
                while process.poll() is None and not over and not progress.stopped:
                    _wait(process, 0.05)
                    over = time_limit is not None and time.perf_counter() - begin > time_limit
            finally:
                killed = process.poll() is None
                if killed:
                    process.kill()
        seconds = time.perf_counter() - begin
        errors.seek(0)
        lines = errors.read().decode(errors="replace").strip().splitlines()
    return Ended(None if killed else process.returncode, seconds, killed and over, lines[-1] if lines else "")


def _wait(process: subprocess.Popen, seconds: float) -> None:
    try:
        process.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        return
