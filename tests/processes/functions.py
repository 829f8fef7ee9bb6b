"""Functions that tests call in other processes: those have to be found by their name."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from planner.base.errors import OptionError
from planner.base.progress import Progress


def square(case: int, progress: Progress) -> int:
    return case**2


def process_id(case: int, progress: Progress) -> int:
    return os.getpid()


def slow(case: float, progress: Progress) -> float:
    """Takes ``case`` seconds."""
    time.sleep(case)
    return case


def refused(case: int, progress: Progress) -> int:
    raise OptionError(f"{case} is refused: give another number.")


def killed_at_first(case: Path, progress: Progress) -> str:
    """Kills its process unless an earlier one has left a mark at ``case``."""
    if not case.exists():
        case.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return case.name


def killed_always(case: int, progress: Progress) -> None:
    os.kill(os.getpid(), signal.SIGKILL)
