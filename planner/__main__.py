"""The program: ``python -m planner`` and the command ``planner``."""

import signal

signal.signal(signal.SIGINT, signal.SIG_DFL)  # until main() sees to it: what is half loaded ends without a traceback

import atexit  # noqa: E402
import gc  # noqa: E402
import os  # noqa: E402
import sys  # noqa: E402
import threading  # noqa: E402
from collections.abc import Callable  # noqa: E402

from planner.base.interrupts import end_like_interrupt, leave_on_interrupt  # noqa: E402

_ALLOCATIONS_PER_COLLECTION = 200_000  # imports alone make 125,000 objects that stay


def main() -> None:
    """Run the command line of the planner."""

    def command_line() -> None:
        from planner.cli import main

        main()

    run(command_line)


def run(command_line: Callable[[], None]) -> None:
    """Run a command line; Ctrl-C and SIGTERM are seen to before anything else is loaded."""
    leave_on_interrupt()
    end_like_interrupt()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # more would wait in loops: our compiled code has its own
    gc.set_threshold(_ALLOCATIONS_PER_COLLECTION)
    try:
        command_line()
    except SystemExit as end:
        if isinstance(end.code, int):
            _leave_at_once(end.code)
        raise


def _leave_at_once(code: int) -> None:
    """End the process without taking apart what it has loaded, which takes 0.15 s; not where a thread still works."""
    if threading.active_count() > 1:
        return
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:  # a full disk, a closed pipe: the interpreter sees to these
        return
    atexit._run_exitfuncs()
    os._exit(code)


if __name__ == "__main__":
    main()
