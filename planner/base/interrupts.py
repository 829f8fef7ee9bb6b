"""Ctrl-C and SIGTERM: as a request to stop and save, or as the end of the process where nothing is to be saved."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from planner.base.errors import printable

INTERRUPTED = 130  # the exit code, as shells have it
NOTHING_TO_SAVE = "stopping; there is nothing to save."
stop_requests: list[Callable[[], bool]] = []
"""Who can tell whether SIGINT has asked for a stop: those that take it for a request at the moment."""
standard_error = [2]
"""File descriptors of standard error, the last one the user's: number 2 leads elsewhere while it is longer than one."""
_SAVING = (
    "stopping, saving what there is (Ctrl-C twice more: leave without saving).",
    "still saving (Ctrl-C once more: leave without saving).",
)


def write_message(sentence: str, lines: int = 1) -> None:
    """A line on standard error from a signal handler, which must not touch Python's own buffers.

    On a terminal it takes the place of the line the cursor is on, and is followed by as many ``lines`` as are drawn
    anew above the cursor.
    """
    number = standard_error[-1]
    on_terminal, sentence = os.isatty(number), printable(sentence)
    text = f"\r\x1b[2Kplanner: {sentence}" + "\n" * max(lines, 1) if on_terminal else f"planner: {sentence}\n"
    with contextlib.suppress(OSError):  # closed, or a full disk
        os.write(number, text.encode())


def leave(sentence: str = NOTHING_TO_SAVE) -> None:
    """End the process now. No exception: one must not fly through C++, nor through a module that is half loaded."""
    write_message(sentence)
    if os.isatty(number := standard_error[-1]):
        os.write(number, b"\x1b[?25h")  # progress bars hide the cursor
    os._exit(INTERRUPTED)


def leave_on_interrupt(sentence: str = NOTHING_TO_SAVE) -> None:
    """From now on SIGINT ends the process with ``sentence``."""
    signal.signal(signal.SIGINT, lambda number, frame: leave(sentence))


@contextmanager
def exit_on_interrupt(sentence: str) -> Iterator[None]:
    """While entered SIGINT ends the process with ``sentence``: for work after all is saved. In the main thread."""
    before = signal.getsignal(signal.SIGINT)
    leave_on_interrupt(sentence)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def catch_signals(asked: threading.Event, sentence: str) -> Iterator[None]:
    """SIGINT and SIGTERM set ``asked``; where it is set already they end the process, with a ``sentence``."""

    def handle(number: int, frame: object) -> None:
        if asked.is_set():
            leave(sentence)
        asked.set()

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class StopRequest:
    """While entered, SIGINT only sets a flag and says so; calling the object tells whether the flag is set.

    As long as the flag was never read there is nothing to save, and SIGINT does what it did before. The second one
    says to wait, the third ends the process. ``drawn`` tells how many lines of progress are on the terminal.
    """

    def __init__(self, drawn: Callable[[], int] = lambda: 1) -> None:
        self._presses, self._called, self._drawn = 0, False, drawn

    def __call__(self) -> bool:
        self._called = True
        return self._pressed()

    def __enter__(self) -> StopRequest:
        self._previous = signal.signal(signal.SIGINT, self._handle)
        stop_requests.append(self._pressed)
        return self

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._previous)
        stop_requests.remove(self._pressed)

    def _pressed(self) -> bool:
        return self._presses > 0

    def _handle(self, number: int, frame: object) -> None:
        if not self._called and callable(self._previous):
            self._previous(number, frame)  # type: ignore[arg-type]
        self._presses += 1
        if self._presses > 2:
            leave("left without saving.")
        write_message(_SAVING[self._presses - 1], self._drawn())
