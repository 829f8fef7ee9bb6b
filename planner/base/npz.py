"""Arrays in ``.npz`` files from elsewhere: what they unpack to is known, and refused, before anything is unpacked."""

from __future__ import annotations

import math
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import IO

import numpy as np

from planner.base.errors import FileError

# what a zip or npy reader, or a header that is not ours, can end in
DAMAGE = (
    *(OSError, EOFError, ValueError, LookupError, TypeError, AttributeError, MemoryError, RecursionError),
    *(RuntimeError, zipfile.BadZipFile, zlib.error, tokenize.TokenError, SyntaxError),
)
_RATIO = 100  # numbers hardly compress: unpacked to 100 times its size, and ``slack``, a file holds none of use


def require_sane_sizes(path: Path, where: str, slack: int, largest: int = 4 << 30) -> None:
    """Raise for a file that would unpack to far more than it is, or whose arrays are not as large as they say.

    ``slack``, ``largest``: bytes, the latter of what is compressed. :class:`FileError` for the former, one of
    :data:`DAMAGE` for all else.
    """
    with zipfile.ZipFile(path) as archive:
        total = sum(item.file_size for item in archive.infolist())
        packed = sum(item.file_size for item in archive.infolist() if item.compress_type != zipfile.ZIP_STORED)
        require_sane_size(path, where, total, slack)
        if packed > largest:
            raise FileError(f"{where} would unpack to {packed} bytes, more than {largest}: give a smaller file.")
        for item in archive.infolist():
            with archive.open(item) as file:
                shape, _, dtype = array_header(file)
                size = file.tell() + math.prod(shape) * dtype.itemsize
            if min(shape, default=0) < 0 or (size != item.file_size and not dtype.hasobject):
                raise ValueError(f"'{item.filename}' says it has shape {shape}, which does not fit its size")


def require_sane_size(path: Path, where: str, total: int, slack: int) -> None:
    """Raise :class:`FileError` where a file's content of ``total`` bytes is far more than it can be packed from."""
    if total > _RATIO * path.stat().st_size + slack:
        raise FileError(f"{where} would unpack to {total} bytes, far more than it is: write it again.")


def array_header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Shape, whether in Fortran's order, and dtype of the array that begins in ``file``; ValueError for none."""
    version = np.lib.format.read_magic(file)
    if version == (1, 0):
        return np.lib.format.read_array_header_1_0(file)
    return np.lib.format.read_array_header_2_0(file)
