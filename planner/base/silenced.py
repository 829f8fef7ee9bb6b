"""Captures text that C and C++ libraries print to standard output and error, so that users do not see it raw."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import re
import sys
import tempfile
import threading
from collections.abc import Iterator
from typing import IO

from planner.base.interrupts import standard_error
from planner.base.process_lock import PROCESS

_log = logging.getLogger(__name__)
_OF_URDFDOM = re.compile(rb"(Error|Warning):   | +at line \d+ in ")  # a message, and its place in urdfdom's source


class Silenced:
    """Captures the process's standard output and error while entered; the debug log has the text.

        with Silenced() as printed:
            model = library.load(path)
        printed.text

    File descriptors belong to the process: one thread at a time, around one call. Where other threads are alive, the
    text is passed on afterwards, as it may be theirs, except for urdfdom's lines.
    """

    def __init__(self) -> None:
        self.text = ""  # complete once left
        self._stack = contextlib.ExitStack()

    def __enter__(self) -> Silenced:
        self._stack.enter_context(PROCESS)
        for stream, number in ((sys.stdout, 1), (sys.stderr, 2)):
            if stream is not None:
                stream.flush()
            self._stack.enter_context(self._captured(number))
        return self

    def __exit__(self, *_: object) -> None:
        ctypes.CDLL(None).fflush(None)  # C buffers what goes to a file
        self._stack.close()
        if self.text:
            _log.debug("a library printed: %s", self.text)

    @contextlib.contextmanager
    def _captured(self, number: int) -> Iterator[None]:
        """Let descriptor ``number`` lead to a file, and read that file afterwards."""
        with tempfile.TemporaryFile() as file:
            before = os.dup(number)
            if number == 2 and len(standard_error) == 1:
                standard_error.append(before)  # a signal handler's message is for the user
            os.dup2(file.fileno(), number)
            try:
                yield
            finally:
                os.dup2(before, number)
                if number == 2 and before in standard_error:
                    standard_error.remove(before)
                os.close(before)
            file.seek(0)
            self._keep(file, number)

    def _keep(self, file: IO[bytes], number: int) -> None:
        lines = file.readlines()
        self.text += b"".join(lines).decode(errors="replace")
        if threading.active_count() > 1:
            with contextlib.suppress(OSError):
                os.write(number, b"".join(line for line in lines if not _OF_URDFDOM.match(line)))

    def complaint(self, start: str = "Error:") -> str:
        """The first line that begins with ``start``, without it, up to its first full stop; empty without one.

        urdfdom writes "Error:   joint 'j' is not unique." and then the place in its source.
        """
        lines = [line.strip() for line in self.text.splitlines()]
        line = next((line for line in lines if line.startswith(start)), "")
        return line.removeprefix(start).strip().partition(". ")[0].rstrip(".")[:200]
