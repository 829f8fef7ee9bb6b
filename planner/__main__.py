"""The program: ``python -m planner`` and the command ``planner``."""

import os
import signal
import sys
from collections.abc import Callable
from importlib import import_module

signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C during the imports ends the program without a traceback
from planner.base.interrupts import leave_on_interrupt  # noqa: E402


def main() -> None:
    """Run the command line of the planner."""
    run(lambda: import_module("planner.cli").main())


def run(command_line: Callable[[], None]) -> None:
    """Run a command line; Ctrl-C and SIGTERM are handled before the other modules load."""
    leave_on_interrupt()
    signal.signal(signal.SIGTERM, lambda number, frame: signal.raise_signal(signal.SIGINT))  # batch systems send it
    _open_streams()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the compiled code has threads of its own
    command_line()


def _open_streams() -> None:
    """Open the null device for each standard stream that was closed before the program began."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):  # open() returns the lowest free number
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115 (open to the end)


if __name__ == "__main__":
    main()
