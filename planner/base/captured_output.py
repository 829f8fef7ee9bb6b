"""Capture of the text that C and C++ libraries print, and the lock of state of the process."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import sys
import tempfile
import threading

from planner.base.interrupts import standard_error

PROCESS = threading.RLock()
"""Held, for a short time, around changes of streams, filters of warnings and OMPL's seeds."""
_log = logging.getLogger(__name__)


class CapturedOutput:
    """Captures standard output and error of the process inside the block, and logs the text at DEBUG.

    with Silenced() as output:
        model = library.load(path)
    output.text
    """

    def __init__(self) -> None:
        self.text = ""  # complete after the block
        self._stack = contextlib.ExitStack()

    def __enter__(self) -> CapturedOutput:
        self._stack.enter_context(PROCESS)
        self._file = self._stack.enter_context(tempfile.TemporaryFile())
        for stream, number in ((sys.stdout, 1), (sys.stderr, 2)):
            if stream is not None:
                stream.flush()
            before = os.dup(number)
            self._stack.callback(os.close, before)
            self._stack.callback(os.dup2, before, number)
            os.dup2(self._file.fileno(), number)
        standard_error.append(before)  # a signal handler's message is for the user
        self._stack.callback(standard_error.pop)
        return self

    def __exit__(self, *_: object) -> None:
        ctypes.CDLL(None).fflush(None)  # C buffers what goes to a file
        self._file.seek(0)
        self.text = self._file.read().decode(errors="replace")
        self._stack.close()
        if self.text:
            _log.debug("a library printed: %s", self.text)

    def first_error(self) -> str:
        """Return the first line with "Error:", up to its first full stop; else an empty text."""
        lines = (line.strip() for line in self.text.splitlines())
        line = next((line for line in lines if line.startswith("Error:")), "")
        return line.removeprefix("Error:").strip().partition(". ")[0].rstrip(".")[:200]
