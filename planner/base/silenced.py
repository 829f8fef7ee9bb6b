"""Catches what C and C++ libraries print by themselves, so that the user does not see their raw text."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import sys
import tempfile
from types import TracebackType
from typing import IO

_log = logging.getLogger(__name__)
_MOST = 1 << 20  # bytes of text that are read back


class Silenced:
    """Keeps what a library prints to the process's standard output and error while entered; the debug log has it.

        with Silenced() as printed:
            model = library.load(path)
        printed.text

    The whole process is silent meanwhile, other threads too: enter it around one call. Where there is no room for a
    file to keep the text in, the library prints as it likes.
    """

    def __init__(self) -> None:
        self.text = ""  # what was printed, once left
        self._stack = contextlib.ExitStack()

    def __enter__(self) -> Silenced:
        with contextlib.suppress(OSError):  # a full disk
            kept = self._stack.enter_context(tempfile.TemporaryFile())
            self._stack.callback(self._read, kept)
            for stream, number in ((sys.stdout, 1), (sys.stderr, 2)):
                if stream is not None:
                    stream.flush()
                before = os.dup(number)
                self._stack.callback(_restore, before, number)
                os.dup2(kept.fileno(), number)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()
        if self.text:
            _log.debug("a library printed: %s", self.text)

    def _read(self, kept: IO[bytes]) -> None:
        kept.seek(0)
        self.text = kept.read(_MOST).decode(errors="replace")

    def complaint(self, start: str = "Error:") -> str:
        """The first line that begins with ``start``, without it, up to its first full stop; empty where there is none.

        urdfdom writes "Error:   joint 'j' is not unique." and then where in its source it was.
        """
        lines = [line.strip() for line in self.text.splitlines()]
        found = next((line for line in lines if line.startswith(start)), "")
        return found.removeprefix(start).strip().partition(". ")[0].rstrip(".")[:200]


def _restore(before: int, number: int) -> None:
    ctypes.CDLL(None).fflush(None)  # C keeps what goes to a file in a buffer of its own
    os.dup2(before, number)
    os.close(before)
