"""Functions that tests call in other processes: those find them by their name."""

import os
import signal
import time
from pathlib import Path
from typing import Any

from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.batch import run
from planner.batch.run import Task

_measure_row = run._measure_row  # a test puts another one in its place


def square(case: int, progress: Progress) -> int:
    return case**2


def process_id(case: float, progress: Progress) -> int:
    """Takes ``case`` seconds."""
    time.sleep(case)
    return os.getpid()


def refused(case: int, progress: Progress) -> int:
    raise OptionError(f"{case} is refused: give another number.")


def kill_at_two(case: int, progress: Progress) -> int:
    if case == 2:
        time.sleep(1.0)  # Dask does not restart a worker that dies as it starts
        os.kill(os.getpid(), signal.SIGKILL)
    return case


def wait_for_stop(case: Path, progress: Progress) -> None:
    """Writes to ``case`` as it begins, and once it is stopped."""
    case.write_text("begun")
    while not progress.stopped:
        time.sleep(0.02)
    case.write_text("stopped")


def kill_at_plan_two(task: Task, progress: Progress, **options: Any) -> run.Row | None:
    if task.name == "far/two":
        os.kill(os.getpid(), signal.SIGKILL)
    return _measure_row(task, progress, **options)
