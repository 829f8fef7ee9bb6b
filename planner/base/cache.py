"""Content hashes, and a cache of computed arrays under such hashes in the user's cache folder.

A file that cannot be read counts as missing, and the arrays are computed again. Errors of writing are ignored.
"""

import contextlib
import hashlib
import io
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from planner.base.errors import PlannerError
from planner.base.files import DAMAGE, make_folder, write_whole

Arrays: TypeAlias = Mapping[str, np.ndarray]

_VERSION = 3  # of the files


def content_hash(values: Iterable[Any]) -> str:
    """Return SHA-256 (hex) over arrays and plain values (their repr), equal on every machine."""
    digest = hashlib.sha256()
    for value in values:
        data = b""
        if isinstance(value, np.ndarray):
            little = np.ascontiguousarray(value, dtype=value.dtype.newbyteorder("<"))
            value, data = (little.dtype.str, little.shape), little.tobytes()
        text = repr(value).encode()
        digest.update((len(text) + len(data)).to_bytes(8, "little") + text + data)
    return digest.hexdigest()


def load_or_compute(kind: str, inputs: Iterable[Any], make: Callable[[], Arrays]) -> Arrays:
    """Return the read-only arrays of ``make``, from the cache if it ran before on the same ``inputs``."""
    path = cache_folder() / kind / f"{content_hash([_VERSION, *inputs])}.npz"
    arrays = None
    with contextlib.suppress(*DAMAGE), np.load(path, allow_pickle=False) as archive:  # zip checks the content (CRC)
        arrays = dict(archive)
    if arrays is None:
        arrays, content = dict(make()), io.BytesIO()
        np.savez(content, allow_pickle=False, **arrays)
        with contextlib.suppress(PlannerError):  # no home, full disk
            make_folder(path.parent)
            write_whole(path, content.getvalue())
    for array in arrays.values():
        array.flags.writeable = False
    return arrays


def cache_folder() -> Path:
    """Return the planner's folder below XDG_CACHE_HOME, or below ~/.cache if that is not an absolute path.

    Without a home the folder is below a device, where no file can be written, not in the working directory.
    """
    named = os.environ.get("XDG_CACHE_HOME", "")
    folder = Path(named if os.path.isabs(named) else os.path.expanduser("~/.cache"))
    return (folder if folder.is_absolute() else Path(os.devnull)) / "planner"
