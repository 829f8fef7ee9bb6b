"""A benchmark as a command: its progress, its report, its exit code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Protocol, TypeVar

from planner.base.progress import Progress
from planner.cli.terminal import run_into, say


class Measured(Protocol):
    """What a benchmark returns: its report, Markdown, and whether that is all that was asked for."""

    @property
    def report(self) -> str: ...
    @property
    def complete(self) -> bool: ...


M = TypeVar("M", bound=Measured)


def measured(folder: Path, run: Callable[[Progress], M]) -> M:
    """The result of a benchmark that writes into ``folder``; its report is shown."""
    result = run_into(folder, run)
    say(result.report)
    return result


def measure(folder: Path, run: Callable[[Progress], Measured]) -> int:
    """Run a benchmark and show its report; the exit code tells whether it is complete."""
    return 0 if measured(folder, run).complete else 130
