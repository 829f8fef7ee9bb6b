"""Ctrl-C and SIGTERM: a request to stop and save, or the end of a process with nothing to save."""

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
"""Functions that return whether SIGINT requested a stop; compiled functions call them."""
standard_error = [2]
"""File descriptors of standard error; the last one is the user's, as number 2 may be redirected."""
_SAVING = (
    "stopping, saving what there is (Ctrl-C two more times: leave without saving).",
    "still saving (Ctrl-C again: leave without saving).",
)


def write_message(sentence: str, lines: int = 1) -> None:
    """Write a line on standard error from a signal handler, which must not touch Python's buffers.

    On a terminal the line replaces that of the cursor; empty ``lines`` follow, which progress bars draw over.
    """
    number = standard_error[-1]
    on_terminal, sentence = os.isatty(number), printable(sentence)
    text = f"\r\x1b[2Kplanner: {sentence}" + "\n" * max(lines, 1) if on_terminal else f"planner: {sentence}\n"
    with contextlib.suppress(OSError):  # closed, or a full disk
        os.write(number, text.encode())


def leave(sentence: str = NOTHING_TO_SAVE) -> None:
    """End the process now, without an exception, which must not pass C++ or a module that is loading."""
    write_message(sentence)
    if os.isatty(number := standard_error[-1]):
        os.write(number, b"\x1b[?25h")  # progress bars hide the cursor
    os._exit(INTERRUPTED)


def leave_on_interrupt(sentence: str = NOTHING_TO_SAVE) -> None:
    """Let SIGINT end the process with ``sentence`` from now on."""
    signal.signal(signal.SIGINT, lambda number, frame: leave(sentence))


@contextmanager
def exit_on_interrupt(sentence: str) -> Iterator[None]:
    """Let SIGINT end the process with ``sentence`` inside the block; for the main thread, after saving."""
    before = signal.getsignal(signal.SIGINT)
    leave_on_interrupt(sentence)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def catch_signals(stop: threading.Event, sentence: str) -> Iterator[None]:
    """Let SIGINT and SIGTERM set ``stop``, and end the process with ``sentence`` if it is set."""

    def handle(number: int, frame: object) -> None:
        if stop.is_set():
            leave(sentence)
        stop.set()

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class StopRequest:
    """A flag that SIGINT sets inside the block; calling the object returns the flag.

    Before the first call there is nothing to save, and SIGINT acts as before. The second SIGINT prints that saving
    goes on, the third ends the process. ``drawn`` returns the number of progress lines on the terminal.
    """

    def __init__(self, drawn: Callable[[], int] = lambda: 1) -> None:
        self._presses, self._called, self._drawn = 0, False, drawn

    def __call__(self) -> bool:
        self._called = True
        return self._is_set()

    def __enter__(self) -> StopRequest:
        self._previous = signal.signal(signal.SIGINT, self._handle)
        stop_requests.append(self._is_set)
        return self

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._previous)
        stop_requests.remove(self._is_set)

    def _is_set(self) -> bool:
        return self._presses > 0

    def _handle(self, number: int, frame: object) -> None:
        if not self._called and callable(self._previous):
            self._previous(number, frame)  # type: ignore[arg-type]
        self._presses += 1
        if self._presses > 2:
            leave("left without saving.")
        write_message(_SAVING[self._presses - 1], self._drawn())
