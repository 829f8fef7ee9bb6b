"""The program: ``python -m planner`` and the command ``planner``."""

import atexit
import gc
import os
import signal
import sys
import threading
from collections.abc import Callable
from importlib import import_module

signal.signal(signal.SIGINT, signal.SIG_DFL)  # until run() sees to it: what is half loaded ends without a traceback
from planner.base.interrupts import end_like_interrupt, leave_on_interrupt  # noqa: E402

_ALLOCATIONS_PER_COLLECTION = 200_000  # imports make 125,000 objects that stay: going through them takes 0.05 s


def main() -> None:
    """Run the command line of the planner."""
    run(lambda: import_module("planner.cli").main())


def run(command_line: Callable[[], None]) -> None:
    """Run a command line; Ctrl-C and SIGTERM are seen to before anything else is loaded."""
    leave_on_interrupt()
    end_like_interrupt()
    _open_streams()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # more would wait in loops: our compiled code has its own
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # to look for them it reads all packages: 0.017 s
    gc.set_threshold(_ALLOCATIONS_PER_COLLECTION)
    try:
        command_line()
    except SystemExit as end:
        if isinstance(end.code, int):
            _leave_at_once(end.code)
        raise


def _open_streams() -> None:
    """Standard streams that were closed before the program began, which Python has None for, lead nowhere."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):  # each takes the number that is free
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115 (open to the end)


def _leave_at_once(code: int) -> None:
    """End the process without taking apart what it has loaded, 0.13 s of a plan's 0.7; not where a thread works on.

    Daemons do not count, they end with the process either way; that of a progress bar is often still about to.
    """
    if any(not thread.daemon for thread in threading.enumerate() if thread is not threading.main_thread()):
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
