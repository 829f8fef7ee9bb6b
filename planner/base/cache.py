"""Arrays that took time to compute, kept in the user's cache folder, each under a hash of its inputs.

A file that cannot be read counts as missing: the arrays are computed again. A cache that cannot be written changes
nothing but the time that is taken.
"""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from planner.base.errors import PlannerError
from planner.base.files import DAMAGE, write_whole
from planner.base.hashing import content_hash

Arrays: TypeAlias = Mapping[str, np.ndarray]

_VERSION = 3  # of the files
_MOST = 1 << 29  # bytes of all files of one kind: the oldest go first


def cached(kind: str, made_of: Iterable[Any], make: Callable[[], Arrays]) -> Arrays:
    """The read-only arrays that ``make`` returns, from the cache where it ran before on the same ``made_of``."""
    path = cache_folder() / kind / f"{content_hash([_VERSION, *made_of])}.npz"
    arrays = _read(path)
    if arrays is None:
        arrays = dict(make())
        _write(path, arrays)
    for array in arrays.values():
        array.flags.writeable = False
    return arrays


def cache_folder() -> Path:
    """The planner's folder below XDG_CACHE_HOME, or below ~/.cache where that is not an absolute path.

    Without a home it is below a device, where nothing can be kept, rather than in the working directory.
    """
    named = os.environ.get("XDG_CACHE_HOME", "")
    folder = Path(named if os.path.isabs(named) else os.path.expanduser("~/.cache"))
    return (folder if folder.is_absolute() else Path(os.devnull)) / "planner"


def _read(path: Path) -> dict[str, np.ndarray] | None:
    with contextlib.suppress(*DAMAGE), np.load(path, allow_pickle=False) as archive:  # zip checks the content (CRC)
        return dict(archive)
    return None


def _write(path: Path, arrays: Arrays) -> None:
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **arrays)
    with contextlib.suppress(OSError, PlannerError):  # no home, full disk
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, content.getvalue())
        _remove_oldest(path.parent)


def _remove_oldest(folder: Path) -> None:
    """Remove the oldest files beyond the bytes that one kind may take."""
    files = sorted((stat.st_mtime_ns, stat.st_size, path) for path in folder.iterdir() if (stat := path.stat()))
    left = _MOST
    for _, size, path in reversed(files):
        left -= size
        if left < 0:
            path.unlink(missing_ok=True)
