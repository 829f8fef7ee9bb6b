"""Files that one run writes into one folder: their record, written last, holds a hash of each of the others.

A run that is killed in between leaves files of two runs side by side; whoever reads one of them notices by the hash.
"""

from __future__ import annotations

import hashlib
import json
import logging
import re
from collections.abc import Iterable
from pathlib import Path

from planner.base.errors import FileError, choices
from planner.base.files import is_file
from planner.base.yamlfile import read_text

_log = logging.getLogger(__name__)
_NAME = re.compile(r"[A-Za-z0-9_.-]{1,100}")  # of a file beside, and nowhere else
RECORDS = ("plan.json", "sweep.json")
_WHY = (
    "another run ended there before it had written all, or somebody changed it since; run it again for files that fit"
)


def hashes(folder: Path, names: Iterable[str]) -> dict[str, str]:
    """SHA-256 (hex) of the files of a ``folder`` by their ``names``, of those that are there."""
    return {name: _hash(folder / name) for name in names if is_file(folder / name)}


def warn_of_mismatch(file: Path) -> None:
    """Log a warning where :func:`mismatch` has something to say."""
    if sentence := mismatch(file):
        _log.warning("%s", sentence)


def mismatch(file: Path) -> str | None:
    """A sentence where ``file`` is not the one that a record beside it was written with; None where nothing says so.

    Of a record itself: where a file that it was written with is another one by now. What is not there says nothing.
    """
    if file.name in RECORDS:
        others = [name for name, digest in _listed(file).items() if _differs(file.with_name(name), digest)]
        return f"{file} was written with another {choices(others)} than stands beside it: {_WHY}." if others else None
    beside = [file.with_name(name) for name in RECORDS]
    of = {record.name: digest for record in beside if (digest := _listed(record).get(file.name)) is not None}
    if of and all(_differs(file, digest) for digest in of.values()):
        return f"{file} is not the one that {choices(of)} beside it was written with: {_WHY}."
    return None


def _listed(record: Path) -> dict[str, str]:
    """The hashes that a record holds by the names of files beside it; none where it cannot be read."""
    try:
        content = json.loads(read_text(record, "record")) if is_file(record) else None
    except (FileError, ValueError, RecursionError):
        return {}
    files = content.get("files") if isinstance(content, dict) else None
    listed = files.items() if isinstance(files, dict) else ()
    return {name: digest for name, digest in listed if isinstance(digest, str) and _NAME.fullmatch(name)}


def _differs(file: Path, digest: str) -> bool:
    return is_file(file) and _hash(file) != digest


def _hash(file: Path) -> str:
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
