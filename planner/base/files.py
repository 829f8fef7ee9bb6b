"""Writing files so that a crash at any moment leaves either the old file or the new one, whole.

Windows is not supported, here or elsewhere in this package: it has no ``fcntl``, whose lock tells a living writer from
a dead one, and OMPL has no wheels for it.
"""

from __future__ import annotations

import contextlib
import fcntl
import glob
import json
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO, Any

from planner.base.errors import FileError
from planner.base.process_lock import PROCESS

_UNFINISHED = ".unfinished"
_ENCODE = json.JSONEncoder(allow_nan=False).encode
_NESTED = frozenset((dict, list, tuple))


def is_file(path: Path) -> bool:
    """Whether there is a regular file; :class:`FileError` for a name that the system cannot even look up."""
    return stat.S_ISREG(_mode(path))


def is_folder(path: Path) -> bool:
    """Whether there is a folder; :class:`FileError` for a name that the system cannot even look up."""
    return stat.S_ISDIR(_mode(path))


def _mode(path: Path) -> int:
    """The mode of ``path`` as ``stat`` gives it, 0 where there is nothing."""
    try:
        return path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return 0
    except (OSError, ValueError) as error:  # a name of 300 characters, a loop of links, a zero byte
        raise FileError(f"{str(path)[:300]} cannot be looked up: {_reason(error)}; check the path.") from None


def _reason(error: OSError | ValueError) -> str:
    return getattr(error, "strerror", None) or str(error)


def write_whole(path: Path, content: bytes, lasting: bool = True) -> None:
    """Write ``content`` as :func:`whole_file` does."""
    with whole_file(path, lasting) as file:
        file.write(content)


@contextlib.contextmanager
def whole_file(path: Path, lasting: bool = True) -> Iterator[IO[bytes]]:
    """A file under a temporary name beside ``path``, then renamed; on a :class:`FileError` an old file is untouched.

    A writer that is killed leaves its temporary file behind; the next one to write ``path`` clears it away. What need
    not survive a power cut, as its readers notice, is not ``lasting``: the disk is not waited for.
    """
    temporary = None
    try:
        _clear_unfinished(path)
        handle, temporary = _open_temporary(path)
        with os.fdopen(handle, "wb") as file:
            yield file
            file.flush()
            if lasting:
                os.fsync(file.fileno())
            os.chmod(temporary, 0o666 & ~_umask())  # mkstemp's 0600 would keep colleagues from reading it
            os.replace(temporary, path)
    except OSError as error:
        if temporary is not None and os.path.exists(temporary):
            os.unlink(temporary)
        raise FileError(f"{path} cannot be written: {error.strerror or error}; choose another place.") from None


def remove(path: Path) -> None:
    """Take a file away if it is there and can be; whoever writes there next says why it cannot."""
    with contextlib.suppress(OSError):
        path.unlink(missing_ok=True)


def write_json(path: Path, record: dict[str, Any]) -> None:
    """Write ``record`` whole or not at all; raises ValueError for a number that is not finite."""
    write_whole(path, (json_text(record) + "\n").encode())


def json_text(value: Any, begin: str = "\n") -> str:
    """JSON with a line for each key, and one for each array that holds neither arrays nor objects.

    Raises ValueError for a number that is not finite. A line ends with ``begin``, which is how the next one begins.
    """
    inner = begin + " "
    if isinstance(value, dict) and value:
        lines = [f"{_key(key)}: {json_text(item, inner)}" for key, item in value.items()]
        return f"{{{inner}{(',' + inner).join(lines)}{begin}}}"
    if isinstance(value, list | tuple) and not _NESTED.isdisjoint(map(type, value)):
        return f"[{inner}{(',' + inner).join([json_text(item, inner) for item in value])}{begin}]"
    return _ENCODE(value)


def _key(key: Any) -> str:
    return _ENCODE(key) if isinstance(key, str) else _ENCODE({key: 0})[1 : -len(": 0}")]


def _open_temporary(path: Path) -> tuple[int, str]:
    """A new file beside ``path``, open and locked for as long as its writer lives."""
    while True:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=_UNFINISHED, dir=path.parent)
        # another writer may take it for litter before it is locked: then try again
        if _lock(handle) is not False and os.path.exists(name):
            return handle, name
        os.close(handle)


def _clear_unfinished(path: Path) -> None:
    """Remove temporary files of ``path`` whose writers have ended: nobody holds a lock on them."""
    for litter in path.parent.glob(f".{glob.escape(path.name)}.????????{_UNFINISHED}"):
        with contextlib.suppress(OSError), litter.open("rb") as file:
            if _lock(file.fileno()):
                litter.unlink()


def _lock(handle: int) -> bool | None:
    """Whether the open file is now locked; False if somebody else holds it, None where files cannot be locked."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


@contextlib.contextmanager
def staged(folder: Path, names: Sequence[str]) -> Iterator[Path]:
    """A folder to write files of these ``names`` into, which take the places of those in ``folder`` once all are whole.

    In the order of the names; what is not written is taken away there. Where something fails ``folder`` is as it was.
    It is made if it does not exist. Raises :class:`FileError` where one of the places cannot be written.
    """
    make_folder(folder)
    taken = next((folder / name for name in names if is_folder(folder / name)), None)
    if taken is not None:
        raise FileError(f"{taken} is a folder, and a file is to be written there: move it, or choose another place.")
    for litter in folder.glob(f".????????{_UNFINISHED}"):  # of writers that have ended
        with _locked(litter) as ended:
            if ended:
                shutil.rmtree(litter, ignore_errors=True)
    try:
        inner = Path(tempfile.mkdtemp(prefix=".", suffix=_UNFINISHED, dir=folder))
    except OSError as error:
        raise FileError(f"{folder} cannot be written: {error.strerror or error}; choose another place.") from None
    try:
        with _locked(inner):
            yield inner
            for name in names:
                if is_file(inner / name):
                    os.replace(inner / name, folder / name)
                else:
                    remove(folder / name)
    except FileError as error:
        raise FileError(str(error).replace(str(inner), str(folder))) from None
    except OSError as error:
        raise FileError(f"{folder} cannot be written: {error.strerror or error}; choose another place.") from None
    finally:
        shutil.rmtree(inner, ignore_errors=True)


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[bool]:
    """Whether nobody else holds the folder meanwhile."""
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        yield False
        return
    try:
        yield bool(_lock(handle))
    finally:
        os.close(handle)


def _umask() -> int:
    """The process's mask, of which no other thread sees another value meanwhile."""
    with contextlib.suppress(OSError, StopIteration):
        lines = Path("/proc/self/status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("Umask:")).split()[1], 8)
    with PROCESS:  # a system without /proc
        mask = os.umask(0o077)
        os.umask(mask)
    return mask


def require_writable_folder(folder: Path, longest_name: str = "roadmap.npz") -> None:
    """Check that ``folder`` can be made and written, without leaving anything behind; :class:`FileError` if not.

    It is made, a file is written into it, and both are taken away again: only so are names that are too long, loops
    of links, and full or read-only disks found before any work is done.
    """
    made: list[Path] = []
    try:
        for part in reversed((folder.absolute(), *folder.absolute().parents)):
            if not os.path.lexists(part):
                part.mkdir()
                made.append(part)
        handle, name = _open_temporary(folder / longest_name)
        with os.fdopen(handle, "wb") as file:
            os.unlink(name)
            file.write(b"\0")
    except (OSError, ValueError) as error:
        raise FileError(f"folder {folder} cannot be written: {_reason(error)}; choose another place.") from None
    finally:
        for part in reversed(made):
            with contextlib.suppress(OSError):  # another run may be writing there by now
                part.rmdir()


def require_writable_file(path: Path) -> None:
    """Check that ``path`` can be written, before any work is done; :class:`FileError` if not."""
    if is_folder(path):
        raise FileError(f"{path} is a folder: give the name of a file.")
    if _mode(path) and not is_file(path):  # it would be replaced by a file: /dev/full, a pipe
        raise FileError(f"{path} is a device, not a file: give the name of a file.")
    require_writable_folder(path.parent, path.name)


def make_folder(folder: Path) -> None:
    """Make ``folder`` and those above it; :class:`FileError` if that cannot be done."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise FileError(f"folder {folder} cannot be made: {_reason(error)}; choose another place.") from None
