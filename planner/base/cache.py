"""Arrays that took time to make, kept in the user's cache: each under a hash of all that it was made of.

What is damaged, cut off or of another version counts as not there: it is made anew. A cache that cannot be read or
written changes nothing but the time that is taken.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.base.hashing import content_hash

Arrays: TypeAlias = Mapping[str, np.ndarray]

_VERSION = 2  # of the files
_MOST = 1 << 29  # bytes of all files of one kind: the oldest go first
_DIGEST = hashlib.sha256().digest_size
_ALIGNED = 8  # bytes: where numbers may begin
_since: dict[Path, int] = {}  # bytes written since a folder was cleared


def cached(kind: str, made_of: Iterable[Any], make: Callable[[], Arrays]) -> Arrays:
    """What ``make`` makes, from the cache where it has been made before of the same values (see ``content_hash``)."""
    path = cache_folder() / kind / f"{content_hash([_VERSION, *made_of])}.kept"
    arrays = _read(path)
    if arrays is None:
        arrays = make()
        _write(path, arrays)
    return arrays


def cache_folder() -> Path:
    """Where the planner keeps what it can make again: below XDG_CACHE_HOME, or where that is not absolute ~/.cache.

    Where the user has no home it is below a device, where nothing can be kept, rather than in the working directory.
    """
    named = os.environ.get("XDG_CACHE_HOME", "")
    folder = Path(named if os.path.isabs(named) else os.path.expanduser("~/.cache"))
    return (folder if folder.is_absolute() else Path(os.devnull)) / "planner"


def _read(path: Path) -> Arrays | None:
    """The arrays of a file; None where there is none whose content has the hash that it begins with."""
    with contextlib.suppress(Exception):  # whatever is wrong with it, the arrays can be made
        content = path.read_bytes()
        if hashlib.sha256(memoryview(content)[_DIGEST:]).digest() == content[:_DIGEST]:
            end = content.index(b"\n", _DIGEST)
            return _arrays(content, json.loads(content[_DIGEST:end]), end + 1)
    return None


def _arrays(content: bytes, header: Iterable[tuple[str, str, list[int]]], at: int) -> Arrays:
    """The arrays, read-only, that lie one after the other from ``at`` on, of each its name, kind and shape."""
    arrays = {}
    for name, kind, shape in header:
        count = math.prod(shape)
        array = np.frombuffer(content, np.dtype(kind), count, at) if count else np.empty(0, kind)
        arrays[name] = array.reshape(shape)
        at += array.nbytes + -array.nbytes % _ALIGNED
    return arrays


def _write(path: Path, arrays: Arrays) -> None:
    header = json.dumps([(name, array.dtype.str, array.shape) for name, array in arrays.items()]).encode()
    parts = [header + b" " * (-(len(header) + 1) % _ALIGNED) + b"\n"]
    for array in arrays.values():
        parts += [array.tobytes(), b" " * (-array.nbytes % _ALIGNED)]
    content = b"".join(parts)
    with contextlib.suppress(OSError, PlannerError):  # without a home, on a full disk
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, hashlib.sha256(content).digest() + content, lasting=False)
        _make_room(path.parent, len(content))


def _make_room(folder: Path, written: int) -> None:
    """Clear a folder at the first of the files that are written to it, and whenever many have been."""
    _since[folder] = _since.get(folder, _MOST) + written
    if _since[folder] >= _MOST // 32:
        _since[folder] = 0
        _clear(folder)


def _clear(folder: Path) -> None:
    """Remove the oldest files beyond the bytes that there are for them all."""
    files = sorted((stat.st_mtime_ns, stat.st_size, path) for path in folder.glob("*.kept") if (stat := path.stat()))
    left = _MOST
    for _, size, path in reversed(files):
        left -= size
        if left < 0:
            path.unlink(missing_ok=True)
