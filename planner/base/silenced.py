"""Catches what C and C++ libraries print by themselves, so that the user does not see their raw text."""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import logging
import os
import re
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from types import TracebackType
from typing import IO

from planner.base.interrupts import standard_error
from planner.base.process_lock import PROCESS

_log = logging.getLogger(__name__)
_MOST = 1 << 20  # bytes of text that are read back
_WAITS, _WAIT = 100, 0.001  # s: how often and how long what another thread is just writing is waited for
_OF_URDFDOM = re.compile(rb"(Error|Warning):   | +at line \d+ in ")  # what it said, and where in its source it was


class Silenced:
    """Keeps what a library prints to the process's standard output and error while entered; the debug log has it.

        with Silenced() as printed:
            model = library.load(path)
        printed.text

    File descriptors belong to the process: one thread at a time, around one call. Where other threads are alive, what
    was printed is passed on afterwards, as it may be theirs, but for lines in the form of urdfdom's. Where there is no
    room for a file to keep the text in, the library prints as it likes.
    """

    def __init__(self) -> None:
        self.text = ""  # what was printed, once left
        self._stack = contextlib.ExitStack()

    def __enter__(self) -> Silenced:
        self._stack.enter_context(PROCESS)
        with contextlib.suppress(OSError):  # a full disk
            for stream, number in ((sys.stdout, 1), (sys.stderr, 2)):
                kept, printed = self._stack.enter_context(_nameless())
                if stream is not None:
                    stream.flush()
                before = os.dup(number)
                self._stack.callback(self._restore, kept, printed, before, number)
                if number == 2 and len(standard_error) == 1:
                    standard_error.append(before)  # what a signal's handler says is not the library's
                os.dup2(kept.fileno(), number)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()
        if self.text:
            _log.debug("a library printed: %s", self.text)

    def _restore(self, kept: IO[bytes], printed: IO[bytes], before: int, number: int) -> None:
        """Let descriptor ``number`` be what it was ``before``, and read what was ``kept`` of it."""
        ctypes.CDLL(None).fflush(None)  # C keeps what goes to a file in a buffer of its own
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(kept, fcntl.LOCK_EX)
        os.dup2(before, number)
        if number == 2 and before in standard_error:
            standard_error.remove(before)
        os.close(before)
        kept.close()
        _wait_for_writers(printed)
        self.text += printed.read(_MOST).decode(errors="replace")
        if threading.active_count() > 1:
            printed.seek(0)
            with contextlib.suppress(OSError), open(os.dup(number), "wb") as out:  # nobody may read there any more
                out.writelines(line for line in printed if not _OF_URDFDOM.match(line))

    def complaint(self, start: str = "Error:") -> str:
        """The first line that begins with ``start``, without it, up to its first full stop; empty where there is none.

        urdfdom writes "Error:   joint 'j' is not unique." and then where in its source it was.
        """
        lines = [line.strip() for line in self.text.splitlines()]
        line = next((line for line in lines if line.startswith(start)), "")
        return line.removeprefix(start).strip().partition(". ")[0].rstrip(".")[:200]


@contextlib.contextmanager
def _nameless() -> Iterator[tuple[IO[bytes], IO[bytes]]]:
    """A file that nobody else finds, to write to and, opened by itself, to read: none is left where Ctrl-C ends us."""
    with tempfile.NamedTemporaryFile("ab", buffering=0, delete=False) as kept:
        try:
            printed = open(kept.name, "rb")  # noqa: SIM115 (closed below)
        finally:
            os.unlink(kept.name)
        with printed:
            yield kept, printed


def _wait_for_writers(printed: IO[bytes]) -> None:
    """Wait until nobody writes to the file any more: a thread that began to before it was closed holds its lock.

    So does a program that was started meanwhile and prints there, for as long as it runs: what it prints is its own.
    """
    for _ in range(_WAITS):
        with contextlib.suppress(BlockingIOError):
            fcntl.flock(printed, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        time.sleep(_WAIT)
