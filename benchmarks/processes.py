"""Cases measured by processes of their own, and the options of a plan as JSON holds them."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from planner.base.progress import QUIET, Progress
from planner.problem.request import PlanRequest


@dataclass(frozen=True)
class Ended:
    """How a process ended: ``code`` is None where it was stopped, or ``over_time``.

    ``last_words``: the last line it wrote to standard error.
    """

    code: int | None
    seconds: float
    over_time: bool
    last_words: str

    @property
    def fault(self) -> str:
        """How a process failed."""
        return f"the process ended with code {self.code}: {self.last_words}"


def run_module(
    module: str, arguments: Sequence[str], progress: Progress = QUIET, time_limit: float | None = None
) -> Ended:
    """Run ``python -m module arguments`` until it ends, ``progress`` is stopped, or ``time_limit`` (s) has passed."""
    begin, over, killed = time.perf_counter(), False, False
    command = [sys.executable, "-m", module, *arguments]
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    ) as process:
        while True:
            try:
                lines = process.communicate(timeout=0.1)[1].decode(errors="replace").strip().splitlines()
                break
            except subprocess.TimeoutExpired:
                over = time_limit is not None and time.perf_counter() - begin > time_limit
                if over or progress.stopped:
                    process.kill()
                    killed = True
    seconds = time.perf_counter() - begin
    return Ended(None if killed else process.returncode, seconds, killed and over, lines[-1] if lines else "")


def run_case(
    module: str, options: Mapping[str, Any], progress: Progress = QUIET, time_limit: float | None = None
) -> tuple[Ended, Any]:
    """How ``python -m module OUT OPTIONS`` ended, and the content of OUT; None where it failed. Both are JSON."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "found.json"
        ended = run_module(module, [str(out), json.dumps(options)], progress, time_limit)
        return ended, json.loads(out.read_text()) if ended.code == 0 else None


def plain_options(request: PlanRequest) -> dict[str, Any]:
    """The options of a plan as JSON holds them."""
    return request.config()


def plan_request(options: Mapping[str, Any]) -> PlanRequest:
    """The request whose :func:`plain_options` these are."""
    return PlanRequest.from_options(
        **{"motion_plan_request" if name == "request" else name: value for name, value in options.items()}
    )
