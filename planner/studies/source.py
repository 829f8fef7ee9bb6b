"""Which source of this package measured a row."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

_SILENT = (
    "cli",
    "view",
    "figures",
    "studies/laws",
    "studies/manipulator",
    "studies/learning",
)  # whose source decides nothing that a benchmark measures


@cache
def source_hash() -> str:
    """Eight digits of a hash of this package's source, apart from what only shows results."""
    package, digest = Path(__file__).resolve().parents[1], hashlib.sha256()
    for path in sorted([*package.rglob("*.py"), *package.rglob("*.[ch]pp")]):
        place = path.relative_to(package)
        if not any(place.is_relative_to(silent) for silent in _SILENT):
            digest.update(f"{place}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()[:8]
