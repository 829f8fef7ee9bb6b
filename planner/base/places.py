"""Where a file or a folder is, as text or as a path."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TypeAlias

from planner.base.errors import FileError

Place: TypeAlias = str | os.PathLike[str]


def place(given: Place, what: str = "path") -> Path:
    """``given`` as a path; :class:`FileError` for anything but text and paths, with ``what`` it is for."""
    try:
        return Path(given)
    except TypeError:
        raise FileError(f"{what} is a {type(given).__name__}, no path: give text or a pathlib.Path.") from None


def place_text(given: Place, what: str = "path") -> str:
    """``given`` as text: text as it is, which may be a name; :class:`FileError` as :func:`place`."""
    return given if isinstance(given, str) else str(place(given, what))
