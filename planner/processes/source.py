"""Which source of this package measured a row."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from pathlib import Path

from planner.base.versions import versions

_PACKAGE = Path(__file__).resolve().parents[1]
_SILENT = ("cli", "view")  # whose source decides nothing that a row holds


def software(*more: Path) -> str:
    """Which software measured a row: versions, the source of this package and ``more`` folders, the kind of machine."""
    named = ", ".join(f"{name} {version}" for name, version in versions().items())
    return f"{named}, source {source_hash(*more)} on {platform.machine()}"


@cache
def source_hash(*more: Path) -> str:
    """Eight digits of a hash of the source of this package, apart from what only shows results, and of ``more``."""
    digest = hashlib.sha256()
    for root in (_PACKAGE, *more):
        for path in sorted([*root.rglob("*.py"), *root.rglob("*.[ch]pp")]):
            place = path.relative_to(root)
            if root != _PACKAGE or not any(place.is_relative_to(silent) for silent in _SILENT):
                digest.update(f"{place}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()[:8]
