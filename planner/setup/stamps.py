"""What tells whether a file has been touched."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import NamedTuple

from planner.base.errors import PlannerError


class Stamp(NamedTuple):
    """A file as it stood: its path, when it was written and ``changed`` (ns), bytes, inode.

    Programs can set back when a file was ``written``, as ``cp -p`` and ``rsync`` do, but not when it was ``changed``.
    """

    path: str
    written: int
    changed: int
    size: int
    inode: int


def stamp_of(path: Path) -> Stamp | None:
    """How a file stands; None where there is none."""
    with contextlib.suppress(PlannerError, OSError):
        if os.path.isfile(path):
            found = path.stat()
            return Stamp(str(path), found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino)
    return None
