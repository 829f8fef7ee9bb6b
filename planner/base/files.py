"""Atomic writes: after a crash either the old file or the new one is complete."""

import contextlib
import errno
import json
import os
import secrets
import tempfile
import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from planner.base.errors import FileError

StrPath: TypeAlias = str | os.PathLike[str]
# np.load raises any of these for a damaged archive
DAMAGE = (
    *(OSError, EOFError, ValueError, LookupError, TypeError, AttributeError, MemoryError, RecursionError),
    *(RuntimeError, zipfile.BadZipFile, zlib.error, tokenize.TokenError, SyntaxError),
)
_UNFINISHED = ".unfinished"


@contextlib.contextmanager
def _writing(what: object, *more: type[Exception]) -> Iterator[None]:
    """Raise :class:`FileError` for an error of the system, or one of ``more``."""
    try:
        yield
    except (OSError, *more) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"{what} cannot be written: {reason}; choose another place.") from None


def write_whole(path: Path, content: bytes) -> None:
    """Write ``content`` under a temporary name, then rename; a :class:`FileError` keeps the old file."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}{_UNFINISHED}")
    with _writing(path, ValueError):
        try:
            with temporary.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)


def write_json(path: Path, record: dict[str, Any]) -> None:
    """Write ``record`` by :func:`write_whole`; ValueError for a number that is not finite."""
    write_whole(path, (json_text(record) + "\n").encode())


def json_text(value: Any, begin: str = "\n") -> str:
    """Return JSON with a line per key, and one per array that holds neither arrays nor objects.

    Raises ValueError for a number that is not finite. ``begin`` is a line break with the indent of the next line.
    """
    inner = begin + " "
    if isinstance(value, dict) and value:
        lines = [f"{json.dumps(str(key))}: {json_text(item, inner)}" for key, item in value.items()]
        return f"{{{inner}{(',' + inner).join(lines)}{begin}}}"
    if isinstance(value, list | tuple) and any(isinstance(item, dict | list | tuple) for item in value):
        return f"[{inner}{(',' + inner).join([json_text(item, inner) for item in value])}{begin}]"
    return json.dumps(value, allow_nan=False)


@contextlib.contextmanager
def stage_files(folder: Path, names: Sequence[str]) -> Iterator[Path]:
    """Yield a temporary folder; its files of these ``names`` replace those in ``folder`` at the end.

    The files are renamed in the order of ``names``; a name that was not written is removed from ``folder``. After an
    error ``folder`` is unchanged. Raises :class:`FileError` if a file cannot be written.
    """
    make_folder(folder)
    taken = next((folder / name for name in names if os.path.isdir(folder / name)), None)
    if taken is not None:
        raise FileError(f"{taken} must be a file, got a folder: move it, or choose another place.")
    with _writing(folder), tempfile.TemporaryDirectory(prefix=".", suffix=_UNFINISHED, dir=folder) as inner:
        try:
            yield Path(inner)
        except FileError as error:
            raise FileError(str(error).replace(inner, str(folder))) from None
        for name in names:
            if os.path.isfile(Path(inner) / name):
                os.replace(Path(inner) / name, folder / name)
            else:
                (folder / name).unlink(missing_ok=True)


def require_writable_folder(folder: Path) -> None:
    """Raise :class:`FileError` unless ``folder``, or its nearest parent that exists, can be written."""
    with _writing(f"folder {folder}", ValueError):
        existing = next(each for each in (folder.absolute(), *folder.absolute().parents) if os.path.lexists(each))
        if not existing.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, f"{existing} is not a folder")
        if not os.access(existing, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, f"no permission in {existing}")


def require_writable_file(path: Path) -> None:
    """Raise :class:`FileError` unless ``path`` can be written."""
    if os.path.exists(path) and not os.path.isfile(path):  # a rename would replace a device: /dev/full, a pipe
        raise FileError(f"{path} is a {'folder' if os.path.isdir(path) else 'device'}: give the name of a file.")
    require_writable_folder(path.parent)


def make_folder(folder: Path) -> None:
    """Make ``folder`` and its parents; :class:`FileError` if that is impossible."""
    with _writing(f"folder {folder}", ValueError):
        folder.mkdir(parents=True, exist_ok=True)
