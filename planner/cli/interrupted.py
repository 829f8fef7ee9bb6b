"""Where an interrupted result goes: never in the place of another one, finished or interrupted."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from pathlib import Path

NAME = "interrupted"


def folder_for_interrupted(folder: Path, names: tuple[str, ...]) -> Path:
    """``folder`` if it has none of the files ``names``; else a new one inside it, so that no result is lost.

    That is 'interrupted', or 'interrupted-2' and so on where an earlier result is there.
    """
    return _first_free(folder, lambda name: folder / name, lambda place: any(os.path.isfile(place / n) for n in names))


def file_for_interrupted(file: Path) -> Path:
    """``file`` if there is none yet; else a new one beside it."""
    return _first_free(file, lambda name: file.with_name(f"{file.stem}.{name}{file.suffix}"), os.path.isfile)


def _first_free(place: Path, named: Callable[[str], Path], taken: Callable[[Path], bool]) -> Path:
    if not taken(place):
        return place
    numbered = (f"{NAME}-{k}" for k in itertools.count(2))
    return next(found for found in map(named, itertools.chain([NAME], numbered)) if not taken(found))


def kept(place: Path, instead: Path) -> str:
    """The sentence for the user; empty where it went into its own place."""
    return "" if place == instead else f". What was in {place} is kept; this is in {instead}"
