"""Where an interrupted result goes: never in the place of a finished one."""

from __future__ import annotations

import json
from pathlib import Path

from planner.base.files import is_file

FOLDER = "interrupted"


def folder_for_interrupted(folder: Path, names: tuple[str, ...]) -> Path:
    """``folder`` if it has none of the files ``names``, or only those of an interrupted result; else one inside it.

    The first of ``names`` is the result's JSON.
    """
    if not any(is_file(folder / name) for name in names) or _is_interrupted(folder / names[0]):
        return folder
    return folder / FOLDER


def file_for_interrupted(file: Path) -> Path:
    """``file`` if there is none yet; else one beside it."""
    return file.with_name(f"{file.stem}.{FOLDER}{file.suffix}") if is_file(file) else file


def kept(place: Path, instead: Path) -> str:
    """The sentence for the user; empty where it went into its own place."""
    return "" if place == instead else f". What was in {place} is kept; this is in {instead}"


def _is_interrupted(record: Path) -> bool:
    try:
        return json.loads(record.read_text())["outcome"] == "interrupted"
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return False
