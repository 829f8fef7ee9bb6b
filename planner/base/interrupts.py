"""Ctrl-C where nothing is to be saved: one sentence, and out; and SIGTERM. Imports next to nothing: it comes first."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from planner.base.printable import printable

INTERRUPTED = 130  # the exit code, as shells have it
NOTHING_TO_SAVE = "stopping; there is nothing to save."
stop_requests: list[Callable[[], bool]] = []
"""Who can tell whether SIGINT has asked for a stop: those that take it for a request at the moment."""
standard_error = [2]
"""File descriptors of standard error, the last one the user's: number 2 leads elsewhere while it is longer than one."""


def tell_at_once(sentence: str, lines: int = 1) -> None:
    """A line on standard error from a signal handler, which must not touch Python's own buffers.

    On a terminal it takes the place of the line the cursor is on, and is followed by as many ``lines`` as are drawn
    anew above the cursor.
    """
    number = standard_error[-1]
    on_terminal, sentence = os.isatty(number), printable(sentence)
    text = f"\r\x1b[2Kplanner: {sentence}" + "\n" * max(lines, 1) if on_terminal else f"planner: {sentence}\n"
    with contextlib.suppress(OSError):  # closed, or a full disk behind it: there is nobody left to tell
        os.write(number, text.encode())


def leave(sentence: str = NOTHING_TO_SAVE) -> None:
    """End the process now. No exception: one must not fly through C++, nor through a module that is half loaded."""
    tell_at_once(sentence)
    if os.isatty(number := standard_error[-1]):
        os.write(number, b"\x1b[?25h")  # progress bars hide the cursor
    os._exit(INTERRUPTED)


def leave_on_interrupt(sentence: str = NOTHING_TO_SAVE) -> None:
    """From now on SIGINT ends the process with ``sentence``."""

    def handle(signum: int, frame: FrameType | None) -> None:
        leave(sentence)

    signal.signal(signal.SIGINT, handle)


def end_like_interrupt() -> None:
    """From now on SIGTERM, by which batch systems and containers end a process, does what SIGINT does: it saves."""
    signal.signal(signal.SIGTERM, lambda signum, frame: signal.raise_signal(signal.SIGINT))


@contextmanager
def leaving_on_interrupt(sentence: str) -> Iterator[None]:
    """While entered SIGINT ends the process with ``sentence``: for work that nobody misses, after all is saved."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.getsignal(signal.SIGINT)
    leave_on_interrupt(sentence)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def until_signal(asked: threading.Event, sentence: str) -> Iterator[None]:
    """SIGINT and SIGTERM set ``asked``; where it is set already they end the process, with a ``sentence``."""

    def handle(number: int, frame: FrameType | None) -> None:
        if asked.is_set():
            leave(sentence)
        asked.set()

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
