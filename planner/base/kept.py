"""Arrays that took time to make, kept in the user's cache: each under a hash of all that it was made of.

What is damaged, cut off or of another version counts as not there: it is made anew. A cache that cannot be read or
written changes nothing but the time that is taken.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.base.hashing import content_hash

Arrays: TypeAlias = Mapping[str, np.ndarray]

_VERSION = 1  # of the files
_MOST = 1 << 29  # bytes of all files of one kind: the oldest go first
_DIGEST = hashlib.sha256().digest_size


def kept(kind: str, made_of: Iterable[Any], make: Callable[[], Arrays]) -> Arrays:
    """What ``make`` makes, from the cache where it has been made before of the same values (see ``content_hash``)."""
    path = cache_folder() / kind / f"{content_hash([_VERSION, *made_of])}.kept"
    found = _read(path)
    if found is None:
        found = make()
        _write(path, found)
    return found


def cache_folder() -> Path:
    """Where the planner keeps what it can make again: below XDG_CACHE_HOME, or ~/.cache."""
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "planner"


def _read(path: Path) -> Arrays | None:
    """The arrays of a file; None where there is none whose content has the hash that it begins with."""
    with contextlib.suppress(Exception):  # whatever is wrong with it, the arrays can be made
        content = path.read_bytes()
        digest, arrays = content[:_DIGEST], memoryview(content)[_DIGEST:]
        if hashlib.sha256(arrays).digest() == digest:
            with np.load(io.BytesIO(arrays), allow_pickle=False) as found:
                return {name: found[name] for name in found.files}
    return None


def _write(path: Path, arrays: Arrays) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    content = buffer.getvalue()
    with contextlib.suppress(OSError, PlannerError):  # without a home, on a full disk
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, hashlib.sha256(content).digest() + content, lasting=False)
        _clear(path.parent)


def _clear(folder: Path) -> None:
    """Remove the oldest files beyond the room that there is for them all."""
    files = sorted((found.st_mtime_ns, found.st_size, path) for path in folder.glob("*.kept") if (found := path.stat()))
    room = _MOST
    for _, size, path in reversed(files):
        room -= size
        if room < 0:
            path.unlink(missing_ok=True)
