"""Functions that tests call in other processes: those find them by their name."""

import os
import signal
import time
from pathlib import Path

from planner.base.errors import OptionError
from planner.base.progress import Progress


def square(case: int, progress: Progress) -> int:
    return case**2


def process_id(case: float, progress: Progress) -> int:
    """Takes ``case`` seconds."""
    time.sleep(case)
    return os.getpid()


def refused(case: int, progress: Progress) -> int:
    raise OptionError(f"{case} is refused: give another number.")


def kill_at_two(case: int, progress: Progress) -> int:
    """Kill the process at case 2; the process id of the others."""
    if case == 2:
        time.sleep(1.0)  # Dask does not restart a worker that dies as it starts
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


def wait_for_stop(case: Path, progress: Progress) -> None:
    """Writes to ``case`` as it begins, and once it is stopped."""
    case.write_text("begun")
    while not progress.stopped:
        time.sleep(0.02)
    case.write_text("stopped")
