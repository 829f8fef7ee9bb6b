"""Writing files so that a crash at any moment leaves either the old file or the new one, whole."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from planner.errors import FileError


def write_whole(path: Path, content: bytes) -> None:
    """Write to a temporary name beside ``path``, then rename; on a :class:`FileError` an old file is untouched."""
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o666 & ~_umask())  # mkstemp's 0600 would keep colleagues from reading it
        os.replace(temporary, path)
    except OSError as error:
        if temporary is not None and os.path.exists(temporary):
            os.unlink(temporary)
        raise FileError(f"{path} cannot be written: {error.strerror or error}; choose another place.") from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def require_writable_folder(folder: Path) -> None:
    """See that ``folder`` can be made and written, leaving no trace; :class:`FileError` if not."""
    existing = next(parent for parent in (folder.absolute(), *folder.absolute().parents) if parent.exists())
    try:
        with tempfile.TemporaryDirectory(dir=existing):
            pass
    except OSError as error:
        raise FileError(
            f"folder {folder} cannot be written: {error.strerror or error}; choose another --out."
        ) from None


def make_folder(folder: Path) -> None:
    """Make ``folder`` and those above it; :class:`FileError` if that cannot be done."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"folder {folder} cannot be made: {error.strerror or error}; choose another --out.") from None
